"""Trials of diagnosis: effects hidden in the data of an independent plant, and whether the tool finds them."""
