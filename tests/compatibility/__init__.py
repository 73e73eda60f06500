"""Fresh installs of robotid on the lowest and the newest versions of what it needs: `make compatibility`.

Read interpreters (which Pythons there are), environment (how one is prepared), trial (what must work in it), outcome
(the table). Nothing here needs more than the standard library, since no environment exists before it has run.
"""
