"""What no effect of the catalogue explains: a torque free to take any shape along one variable of the motion.

Order of reading: `basis` (piecewise linear curves along a variable, as forces on the joint), `curve_term` (such a curve
as a term of the model, which feeds back on the motion that it lies along), `curve_course` (as a torque in time, where
it can be no term, or where causes are sought beside it), `curve_fit` (the curves that explain most of what a model
leaves). `settings` holds the tuning constants.
"""
