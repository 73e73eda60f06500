"""Streams that are closed, full, broken or not UTF-8: one line or silence, and the exit code of the work."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from robotid.cli.console import print_json, print_message, print_tables
from robotid.cli.streams import PLAIN
from robotid.errors import InputError, printable
from robotid.pipeline.check import FILE as KEPT_CHECK
from robotid.report.tables.table import Table

ROBOTID = f"{sys.executable} -m robotid"
needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")


def shell(line: str, **variables: str) -> subprocess.CompletedProcess[bytes]:
    """A line of bash in which $R is robotid."""
    environment = {**os.environ, "R": ROBOTID, **variables}
    return subprocess.run(["bash", "-c", f"set -o pipefail; {line}"], capture_output=True, env=environment, timeout=60)


@pytest.mark.parametrize("command", ["$R explain --json", "$R explain", "$R --help"])
def test_a_reader_that_leaves_is_no_failure(command: str) -> None:
    done = shell(f"{command} | head -c 1; exit ${{PIPESTATUS[0]}}")
    assert (done.returncode, len(done.stdout), done.stderr) == (0, 1, b"")


def test_a_reader_that_leaves_hides_no_failure() -> None:
    done = shell("$R status absent.yaml 2>&1 | true; exit ${PIPESTATUS[0]}")
    assert done.returncode == 2


@needs_full
def test_results_that_cannot_be_written_are_a_failure() -> None:
    done = shell("$R explain --json > /dev/full")
    assert (done.returncode, done.stderr) == (3, b"stdout: cannot be written: No space left on device\n")


@needs_full
@pytest.mark.parametrize("end", ["2>/dev/full", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_talk_that_cannot_be_shown_is_left_out(end: str) -> None:
    done = shell(f"$R status absent.yaml {end}")
    assert (done.returncode, done.stdout, done.stderr) == (2, b"", b"")


def test_a_closed_stdout_is_silence() -> None:
    done = shell("$R explain --json >&-")
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp437"])
def test_a_power_that_the_encoding_lacks_is_written_out(encoding: str) -> None:
    shown = shell("$R explain inertia", PYTHONIOENCODING=encoding).stdout.decode(encoding)
    assert ("kg m²" if encoding != "ascii" else "kg m^2") in shown


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp437"])
def test_a_terminal_that_is_not_utf_8(encoding: str) -> None:
    done = shell("$R explain coulomb && $R explain && $R explain coulomb --json", PYTHONIOENCODING=encoding)
    assert (done.returncode, done.stderr) == (0, b"")
    done = shell("$R explain coulomb --json", PYTHONIOENCODING=encoding)
    assert json.loads(done.stdout.decode(encoding)) == json.loads(shell("$R explain coulomb --json").stdout)
    assert all(len(plain.encode("ascii")) for plain in PLAIN.values())


def test_a_file_name_that_is_no_text(tmp_path: Path) -> None:
    name = os.fsencode(tmp_path) + b"/a\xff\x1b[31m.yaml"
    done = subprocess.run([*ROBOTID.split(), "status", name], capture_output=True, timeout=60)
    assert done.returncode == 2
    assert done.stderr.endswith(b"/a\\xff\\x1b[31m.yaml: there is no such file; `robotid new NAME` writes one\n")
    Path(os.fsdecode(name)).write_text("robot: 3\n")
    done = subprocess.run([*ROBOTID.split(), "status", name, "--json"], capture_output=True, timeout=60)
    assert (done.returncode, done.stderr.count(b"\n")) == (2, 1)


def test_no_message_and_no_table_steers_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    hostile = "a\x1b]0;b\x07\r\u202ec\x9b2J\x00"
    print_message(hostile + "\nnext")
    print_message(str(InputError(f"{hostile}\nfaked: line", where=hostile, hint=hostile)))
    print_tables([Table(hostile, (hostile, "b"), ((hostile, "x\ny"),), hostile)])
    out, err = capsys.readouterr()
    assert all(c.isprintable() or c == "\n" for c in out + err)
    assert err.splitlines()[0] == "a\\x1b]0;b\\x07\\r\\u202ec\\x9b2J\\x00"
    assert len(err.splitlines()) == 3
    assert "x\\ny" in out
    assert printable("a\u00a0b ä 日本 \udcff") == "a\u00a0b ä 日本 \\xff"


def test_json_holds_what_no_stream_can_encode(capsys: pytest.CaptureFixture[str]) -> None:
    print_json({"file": "a\udcffb", "ä": 1})
    out = capsys.readouterr().out
    assert json.loads(out) == {"file": "a\udcffb", "ä": 1}
    assert out.isascii()


RUN = """
import sys, threading, signal
from robotid.cli.entry import main
sys.exit(main())
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("after", [0.35, 1.2, 2.5])
def test_a_run_is_interrupted_wherever_it_is(number: signal.Signals, after: float, tmp_path: Path) -> None:
    smoke = Path(__file__).parents[2] / "configs" / "smoke.yaml"
    arguments = [sys.executable, "-c", RUN, "run", str(smoke), "--out", str(tmp_path / "run"), "--quiet"]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        time.sleep(after)
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert out == b"" or err.startswith(b"interrupted; what was reached is saved")
    assert err.startswith(b"interrupted")
    assert err.count(b"\n") == 1
    left = os.listdir(tmp_path / "run") if (tmp_path / "run").exists() else []
    assert not [name for name in left if name.startswith(".") and name != KEPT_CHECK]
