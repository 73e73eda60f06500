"""What a page lets a browser do: run its own script, and nothing that a name or a file smuggled in."""

from __future__ import annotations

import base64
import hashlib
import re
from html import unescape
from pathlib import Path

from matplotlib.figure import Figure
from support.report_findings import findings

import robotid.report
from robotid.report.origin import Origin, Source
from robotid.report.page import page
from robotid.report.style.svg import identifier, inline

MADE = Source("fit", "model.h5", "robotid fit a.yaml", "1.0", "2025-01-01", "ab" * 32, {}, 1, {"python": "3.11"})
HOSTILE = '"><script>alert(1)</script><img src=x onerror="alert(1)'


def test_the_policy_allows_the_script_of_the_page_alone() -> None:
    text = page(findings(), (), Origin("0123", "robot: {}\n", (MADE,), {}), HOSTILE)
    policy = re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', text)
    assert policy is not None
    rules = dict(rule.strip().split(" ", 1) for rule in unescape(policy[1]).split(";"))
    scripts = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    assert len(scripts) == 1
    digest = base64.b64encode(hashlib.sha256(scripts[0].encode()).digest()).decode()
    assert rules["script-src"] == f"'sha256-{digest}'"
    assert rules["default-src"] == rules["base-uri"] == rules["form-action"] == "'none'"
    assert text.index(policy[0]) < text.index("<script")
    assert HOSTILE not in text


def test_the_script_makes_elements_and_no_markup() -> None:
    script = (Path(robotid.report.__file__).parent / "assets" / "page.js").read_text(encoding="utf-8")
    assert not re.search(r"innerHTML|outerHTML|insertAdjacent|document\.write|eval\(|new Function", script)


def test_a_name_ends_no_attribute() -> None:
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0.0, 1.0])
    axes.imshow([[0.0, 1.0]], clip_on=True)
    text = inline(figure, HOSTILE)
    found = re.findall(r' id="([^"]*)"', text)
    assert found
    assert all(re.fullmatch(r"[A-Za-z0-9_-]+", one) for one in found)
    assert "script" in identifier(HOSTILE)
    assert "<script" not in text
