"""The configuration, a YAML file. Order of reading: `load` (the way from a file to a checked configuration), `tree`
(its text with lines), `override` (--set), `former_keys`, `schema` with the sections `robot`, `records`, `columns`,
`excitation` and `plant`, `check` (what one section must know of another), `config_error` and `suggest` (what is wrong,
and what was meant), `effects` (the effect that a name means), `extended` and `template` (configurations that are
written).
"""
