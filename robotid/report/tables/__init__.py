"""What the stages made, as tables for people and JSON for scripts: a module a content, with `tables(content)` and
`document(content)`, named by the stage's row in `robotid.pipeline.table`. `generic` shows any other dataclass."""
