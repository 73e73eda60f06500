"""The command line. Order of reading: `app` (the commands), `options` (what they share), `stages` with `perform` and
`closing` (the commands of the pipeline), `console` and `progress` (what a person sees), and a module for each further
command: `report`, `status`, `show`, `export`, `explain`, `new`, `example`.

Modules that `app` imports at once import nothing heavy, so that `robotid --help` answers at once.
"""
