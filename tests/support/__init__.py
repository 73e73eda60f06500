"""What tests share: made-up records, models fitted to them, and ways to look at pages and files."""
