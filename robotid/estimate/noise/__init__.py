"""The noise of a simulation's residual, by the places where it arises.

Read `response` (how a torque error shows in the output of a joint that slips), `whitening` (the filter that a noise
asks for), `lines` (the whitened spectrum of a residual), `passage` and `passed` (what of the torque's noise shows along
a motion with reversals), `reversals` (where a motion tells of no noise), `levels` (how much of each noise a residual
shows), `averages` (what it leaves open) and `information` (what that does to an estimate).
"""
