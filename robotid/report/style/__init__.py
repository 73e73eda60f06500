"""How figures look: `axes` (colours, grids, labels), `svg` (a figure as part of a page)."""
