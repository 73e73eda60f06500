"""The body of a robot: all its links at once, from the torques of all axes.

Order of reading: `chain` and `urdf` (where the axes sit), `regressor` (torques linear in the links' parameters),
`base_parameters` (which combinations of them matter), `consistent` (parameters that a body can have), `equations` and
`identification` (the two estimates), `results`; `pinocchio_model` compares with another implementation.
"""
