"""Files with random damage: an exit code of the contract, one line on stderr, and soon."""

from __future__ import annotations

import contextlib
import io
import random
import shutil
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from scipy.io import savemat
from support.paths import ROOT

from robotid.cli.app import main
from robotid.errors import printable

CODES = {0, 2, 3, 4, 5}
MAX_SECONDS = 20.0
WORDS = (
    b"&a [*a]",
    b"<<: *a",
    b"!!int x",
    b"9" * 400,
    b"nan",
    b"-1e308",
    b"\x1b[31m",
    b"\xff\xfe",
    b"[" * 60,
    b"{a: ",
    b"null",
    b"''",
)


@dataclass(frozen=True, slots=True)
class Subject:
    """A file that is damaged, and the command that reads it. binary : damage is to bytes, not to words."""

    file: Path
    command: tuple[str, ...]
    binary: bool


CONFIGURATION = """\
robot:
  name: axis
  model: {motor: [inertia, viscous, coulomb]}
records:
  - {name: day1, role: estimate, file: FILE}
"""


def subjects(folder: Path, run: Path) -> tuple[Subject, ...]:
    """One file of every kind, in a folder. run : a finished run directory of the smoke configuration."""
    t = np.arange(400) * 0.01
    speed = 5 * np.sin(2 * t) + 3 * np.sin(5 * t)
    angle = np.cumsum(speed) * 0.01
    columns = {"t": t, "tau_m": 0.1 * np.gradient(speed, 0.01) + 0.05 * np.sign(speed), "phi_m": angle, "dphi_m": speed}
    with h5py.File(folder / "log.h5", "w") as file:
        for name, values in columns.items():
            file.create_dataset(name, data=values, compression="gzip")
    np.savez_compressed(folder / "log.npz", **columns)  # type: ignore[arg-type]
    savemat(folder / "log.mat", columns, do_compression=True)
    rows = np.column_stack(list(columns.values()))
    np.savetxt(folder / "log.csv", rows, delimiter=",", header=",".join(columns), comments="")
    made = []
    for suffix in ("csv", "mat", "h5", "npz"):
        config = folder / f"{suffix}.yaml"
        config.write_text(CONFIGURATION.replace("FILE", f"log.{suffix}"))
        command = ("collect", str(config), "--out", str(folder / f"run-{suffix}"), "--quiet")
        made.append(Subject(folder / f"log.{suffix}", command, binary=suffix != "csv"))
    smoke = shutil.copy(ROOT / "configs" / "smoke.yaml", folder / "smoke.yaml")
    made.append(Subject(Path(smoke), ("run", str(smoke), "--out", str(folder / "none"), "--dry-run"), binary=False))
    model = Path(shutil.copy(run / "model.h5", folder / "model.h5"))
    made.append(Subject(model, ("show", str(model), "--json"), binary=True))
    return tuple(made)


def mutated(content: bytes, rng: random.Random, *, binary: bool) -> bytes:
    """A content with one to four pieces of damage."""
    found = bytearray(content)
    changes: Mapping[str, Callable[[bytearray], None]] = {
        "flip": lambda b: b.__setitem__(rng.randrange(len(b)), rng.randrange(256)),
        "cut": lambda b: b.__delitem__(slice(rng.randrange(len(b)), None)),
        "drop": lambda b: b.__delitem__(slice(at := rng.randrange(len(b)), at + rng.randrange(1, 40))),
        "twice": lambda b: b.__setitem__(slice(at := rng.randrange(len(b)), at), b[at : at + rng.randrange(1, 200)]),
        "word": lambda b: b.__setitem__(slice(at := rng.randrange(len(b)), at), rng.choice(WORDS)),
        "head": lambda b: b.__setitem__(rng.randrange(min(len(b), 2048)), rng.choice((0, 1, 127, 128, 255))),
    }
    usual = ("flip", "head", "flip", "head", "drop", "cut") if binary else ("flip", "cut", "drop", "twice", "word")
    for _ in range(rng.randrange(1, 5)):
        if found:
            changes[rng.choice(usual)](found)
    return bytes(found)


def complaint(subject: Subject, content: bytes) -> str:
    """What is wrong with how a command takes a damaged file, empty where nothing is."""
    subject.file.write_bytes(content)
    out, err, began = io.StringIO(), io.StringIO(), time.monotonic()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(subject.command)
    seconds, text = time.monotonic() - began, err.getvalue()
    if code not in CODES or "Traceback" in text:
        return f"exit code {code}: {text[-800:]}"
    talks = bool(code) and text.count("\n") != 1  # what was done may take several lines
    if talks or "Warning" in text or printable(text, keep="\n") != text:
        return f"stderr is {text[-800:]!r}"
    return f"it took {seconds:.1f} s" if seconds > MAX_SECONDS else ""
