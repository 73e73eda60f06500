"""Whether detection limits hold: effects of a third of the limit, of its size and of twice it, on drawn machines."""
