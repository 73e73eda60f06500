from __future__ import annotations

from collections.abc import Iterator

import pytest
from support import fake_stages
from support.fake_stages import CALLS, FAILURES

from robotid.pipeline import execute as walking


@pytest.fixture
def table(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Three made-up stages in place of the table's own, and a clean account of their calls."""
    monkeypatch.setattr(walking, "STAGES", fake_stages.STAGES)
    CALLS.clear()
    FAILURES.clear()
    yield
    FAILURES.clear()
