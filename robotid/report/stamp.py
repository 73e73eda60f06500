"""The stamp of a page: the digest of what it shows, by which it is known to be up to date."""

from __future__ import annotations

import re

STAMP = re.compile(r'<meta name="robotid-stamp" content="([0-9a-f]+)">')


def stamp_of(text: str) -> str | None:
    """The stamp of a page, None of any other text."""
    found = STAMP.search(text)
    return found.group(1) if found else None
