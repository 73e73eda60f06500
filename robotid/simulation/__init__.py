"""Simulation of a joint, and the exact derivatives of its motion.

Read in this order: `friction` (one step over a sampling interval), `newton` (Newton's method over all samples of a
window), `fallback` (LSODA where that fails), `first_guess` and `actuator` (what a simulation starts from), `simulate`
and `trajectory` (open loop; `in_turns` puts one joint beside several recordings), `sensors` (what is measured of a
motion), `sensitivities` and `internal_states` (derivatives, and the memory of effects that a given motion drives),
`closed_loop` (the virtual robot).
"""
