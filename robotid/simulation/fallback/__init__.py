"""The fallback where Newton's method fails: `lsoda` integrates sample by sample, `cache` remembers the answers."""
