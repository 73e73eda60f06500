"""The language of mechanics: a joint is a sum of terms at ports, and everything else is derived from their partials.

Read in this order: `port` and `parameters` (where an effect acts, and its numbers), `term` and `channel` (the two
families of effects), `structure` (which effects a model has), `geometry` and `layout` (coordinates, and the rows of the
state), `derivatives` and `port_motion` (tangents, and the motion that a term acts on), `joint` (the equations of
motion with exact derivatives), `linear` (the joint at an operating point), `joint_with_candidates` (effects that are
missing). Others assemble a `Joint` from a `Structure` by `robotid.catalogue.assemble`.
"""
