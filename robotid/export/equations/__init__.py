"""The equations of motion of a joint as text of a programming language.

Order of reading: `node` (a formula as a graph), `traced` (arrays of formulae, which numpy's functions extend),
`trace` (the equations of a joint, found by evaluating it with formulae for numbers), `code` (formulae as statements of
a language). No effect is named here: an effect is translated where its file uses functions that `traced` knows.
"""
