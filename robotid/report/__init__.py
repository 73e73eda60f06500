"""What people see of results. Order of reading: `findings` (all that a run has found), `numbers` (how numbers are
written), `tables` (results as tables and JSON), `style` and `drawing` (results on axes), `figures` (a figure of any
result), `sections` (what the page shows, a class each), `summary` (the answer in a paragraph), `page` (all of it as one
HTML file), `stamp` and `origin` (what the page states about itself), `save` (figures as files), `display` (results that
show themselves in Python).
"""
