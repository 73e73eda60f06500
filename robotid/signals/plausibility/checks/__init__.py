"""The checks, one file for each family. Every `Check` that a file of this folder defines is asked."""
