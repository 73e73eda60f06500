"""What the manual takes from the code: `make docs` writes it between the marks of the pages."""
