"""What is told while stages work: time left, a table of fits, plain lines where there is no terminal."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import nullcontext
from io import StringIO
from pathlib import Path
from typing import cast

import pytest
from rich.console import Console
from support.paths import ROOT

from robotid.cli import perform, progress
from robotid.cli.app import main
from robotid.cli.progress import Watch, live_display, watching
from robotid.numerals import duration
from robotid.progress import Begun, Iteration, Progress, Step


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def step(model: str, number: int = 1) -> Step:
    return Step(model, ("m1", "m2", "m3"), Iteration(number, 12.5, 0.25))


@pytest.fixture
def watch() -> Watch:
    return Watch(Clock())


def hear(watch: Watch, after: float, event: Begun | Progress | Step) -> None:
    cast(Clock, watch.clock).now += after
    watch.update(event)


def test_the_time_left_is_that_of_what_is_not_done_at_the_pace_so_far(watch: Watch) -> None:
    hear(watch, 0.0, Begun("diagnose"))
    hear(watch, 7.0, Progress("a", 0, 10))  # loading before it is not counted
    assert watch.left is None
    hear(watch, 8.0, Progress("b", 2, 10))
    assert watch.left == pytest.approx(32.0)
    cast(Clock, watch.clock).now += 30.0
    assert watch.left == pytest.approx(2.0)
    cast(Clock, watch.clock).now += 3.0
    assert watch.left is None, "it takes longer than foreseen, and nobody knows how long"
    assert watch.line() == "diagnose: b, 20 % done, 48 s"


def test_a_new_count_begins_anew(watch: Watch) -> None:
    hear(watch, 0.0, Begun("diagnose"))
    hear(watch, 0.0, Progress("first round", 0, 10))
    hear(watch, 20.0, Progress("first round", 10, 10))
    hear(watch, 5.0, Progress("second round", 0, 10))
    hear(watch, 4.0, Progress("second round", 4, 10))
    assert watch.left == pytest.approx(6.0)
    assert watch.line() == "diagnose: second round, 40 % done, 29 s, about 6 s left"


def test_of_what_nobody_can_count_only_the_time_is_told(watch: Watch) -> None:
    hear(watch, 0.0, Begun("extend"))
    hear(watch, 65.0, Progress("refitting"))
    assert watch.line() == "extend: refitting, 1 min 05 s"
    assert watch.left is None


def test_fits_are_counted_by_models(watch: Watch) -> None:
    hear(watch, 0.0, Begun("fit"))
    hear(watch, 4.0, step("m1"))
    hear(watch, 6.0, step("m2"))
    assert watch.left == pytest.approx(12.0)
    hear(watch, 1.0, step("m2", 2))
    assert watch.left == pytest.approx(11.0)


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.4, "0 s"), (59.4, "59 s"), (60, "1 min 00 s"), (125, "2 min 05 s"), (4200, "1 h 10 min")]
)
def test_duration(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def drawn(watch: Watch, width: int) -> str:
    console = Console(file=StringIO(), width=width, force_terminal=True, color_system=None)
    console.print(live_display(watch, "*"))
    return cast(StringIO, console.file).getvalue()


@pytest.mark.parametrize("width", [60, 120])
def test_the_picture_of_a_fit(width: int, watch: Watch) -> None:
    assert drawn(watch, width) == "\n"
    hear(watch, 0.0, Begun("fit"))
    hear(watch, 3.0, step("m1", 7))
    hear(watch, 3.0, step("m2", 2))
    lines = drawn(watch, width).splitlines()
    assert [line.split() for line in lines[2:5]] == [
        ["m1", "7", "12.5", "0.25", "done"],
        ["m2", "2", "12.5", "0.25", "fitting"],
        ["m3", "waits"],
    ]
    assert re.fullmatch(r"\* fit m2 +━+.* 33 % 6 s 6 s left *", lines[5])
    assert all(len(line) <= width for line in lines)


def test_a_long_label_is_cut(watch: Watch) -> None:
    hear(watch, 0.0, Begun("diagnose"))
    hear(watch, 0.0, Progress("refitting with " + "very_" * 30 + "long_name", 3, 9))
    (line,) = drawn(watch, 60).splitlines()
    assert len(line) <= 60
    assert "… " in line
    assert "33 %" in line


def test_plain_lines(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    monkeypatch.setattr(progress, "Watch", lambda: Watch(clock))
    with watching(quiet=False) as log:
        assert log is not None
        log(Begun("collect"))
        log(Progress("set1", 0, 4))
        clock.now += 6.0
        log(Progress("set2", 1, 4))
        log(Progress("set3", 2, 4))
        log(Begun("fit"))
        log(step("m1"))
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == [
        "collect: set2, 25 % done, 6 s, about 18 s left",
        "m1  iteration   1  cost 1.250000e+01  decrease 2.5e-01",
    ]


def test_quiet() -> None:
    with watching(quiet=True) as log:
        assert log is None


@pytest.fixture
def on_terminal(finished: str, tmp_path: Path) -> Callable[..., str]:
    """What a command writes to a terminal of 80 columns, where all stages have run."""

    def run(*arguments: str, **environment: str) -> str:
        leader, follower = pty.openpty()
        plain = {key: value for key, value in os.environ.items() if key != "NO_COLOR"}
        settings = {"TERM": "xterm-256color", "COLUMNS": "80", "PYTHONPATH": str(ROOT)}
        process = subprocess.Popen(
            [sys.executable, "-m", "robotid", *arguments],
            stdin=follower,
            stdout=follower,
            stderr=follower,
            cwd=tmp_path,
            env=plain | settings | environment,
        )
        os.close(follower)
        written = b""
        while True:
            try:
                part = os.read(leader, 65536)
            except OSError:  # the other end is closed
                break
            written += part
        os.close(leader)
        assert process.wait() == 0, written.decode()
        return written.decode()

    return run


COLOUR = re.compile(r"\x1b\[[0-9;]*3[0-9][0-9;]*m")
CURSOR = re.compile(r"\x1b\[\?25[lh]")


def test_on_a_terminal_it_is_live_and_coloured(on_terminal: Callable[..., str]) -> None:
    written = on_terminal("run", "axis.yaml", "--set", "fit.max_iterations=7")
    assert CURSOR.search(written)
    assert COLOUR.search(written)
    assert "validate: runs/axis/validation.h5 written in " in written
    assert written.rstrip().splitlines()[-1].startswith("next: robotid ")


def test_without_colours(on_terminal: Callable[..., str]) -> None:
    written = on_terminal("validate", "axis.yaml", "--force", NO_COLOR="1")
    assert not COLOUR.search(written)
    assert "Fit [%]" in written


def test_a_terminal_that_can_do_nothing(on_terminal: Callable[..., str]) -> None:
    written = on_terminal("fit", "axis.yaml", "--force", TERM="dumb")
    assert "\x1b" not in written
    assert "m1  iteration   1  cost " in written


def test_quiet_and_json_on_a_terminal(on_terminal: Callable[..., str]) -> None:
    assert on_terminal("fit", "axis.yaml", "--force", "--quiet") == ""
    assert on_terminal("fit", "axis.yaml", "--quiet", "--json").startswith("{")


def test_no_silence_is_long(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    monkeypatch.setattr(progress, "Watch", lambda: Watch(clock))
    lines = progress._Lines()
    clock.now += 100.0
    lines.beat()
    assert capsys.readouterr().err == "", "nothing is at work"
    lines(Begun("fit"))
    lines(Progress("m1", 0, 2))
    for after, expected in (
        (29.0, ""),
        (1.5, "fit: m1, 0 % done, 30 s\n"),
        (29.0, ""),
        (1.5, "fit: m1, 0 % done, 1 min 01 s\n"),
    ):
        clock.now += after
        lines.beat()
        assert capsys.readouterr().err == expected
    clock.now += 20.0
    lines(step("m1"))
    clock.now += 20.0
    lines.beat()
    assert capsys.readouterr().err.count("\n") == 1, "an iteration is a line, too"


def test_a_stage_that_has_ended_is_not_said_to_go_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clock, events = Clock(), list[object]()
    monkeypatch.setattr(progress, "Watch", lambda: Watch(clock))
    lines = progress._Lines()

    def noted(event: Begun | Progress | Step) -> None:
        events.append(event)
        lines(event)

    monkeypatch.setattr(perform, "watching", lambda **_: nullcontext(noted))
    assert main(("excite", str(ROOT / "configs" / "smoke.yaml"), "--out", str(tmp_path))) == 0
    assert events[0] == Begun("excite")
    assert events[-1] == Begun("")
    capsys.readouterr()
    clock.now += 100.0
    lines.beat()
    assert capsys.readouterr().err == ""


def test_the_heartbeat_ends_with_its_block() -> None:
    beats: list[float] = []
    with progress._heartbeat(lambda: beats.append(0.0)):
        assert [t.name for t in threading.enumerate()].count("progress") == 1
    assert "progress" not in [t.name for t in threading.enumerate()]
