"""What happened once in a record, and is no property of the machine: a push, a knock, a jump of friction, a drift.

Order of reading: `applied` (the torque of a known event, and records without it), `bins` (the answer of the output to a
torque in each short stretch of a record, from which that to any longer one is a sum), `torque_errors` (what errors in
proportion to the torque may pass for), `shapes` (the events that are compared: where they begin and end, and what each
explains), `wander` (what a torque that wanders by itself may pass for), `detection` (the largest event of all records,
and its significance against what the rest of its record holds, and beside a wander). `settings` holds the tuning
constants.
"""
