"""Everything wrong that a measured file may hold, with the exact line that a person reads and the exit code."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat
from support.damaged_file import times_refused

from robotid.cli.app import main
from robotid.model.array import Array

H = 0.01

CONFIG = """
robot: {{name: axis, model: {{motor: [inertia, viscous, coulomb]}}}}
records:
  - {{name: day1, file: {file}{record}}}
"""


def good(n: int = 100) -> dict[str, Array]:
    """A second of an inertia of 0.02 kg m2 that is swung to and fro."""
    t = np.arange(n) * H
    return {"t": t, "tau_m": -0.02 * 49 * np.sin(7 * t), "phi_m": np.sin(7 * t), "dphi_m": 7 * np.cos(7 * t)}


def with_sample(signal: str, k: int | slice, value: float) -> dict[str, Array]:
    columns = good()
    columns[signal][k] = value
    return columns


def cut(first: int, last: int) -> dict[str, Array]:
    return {name: np.delete(values, slice(first, last)) for name, values in good().items()}


def csv(columns: dict[str, Array], head: str | None = None) -> str:
    rows = [",".join(f"{cell:.9g}" for cell in row) for row in zip(*columns.values(), strict=True)]
    return "\n".join([",".join(columns) if head is None else head, *rows]) + "\n"


def with_line(number: int, line: str) -> str:
    lines = csv(good()).splitlines()
    lines[number - 1] = line
    return "\n".join(lines)


@dataclass(frozen=True)
class Case:
    """A file, by its text or by what writes it, what the record says beside it, and what a person reads."""

    name: str
    content: str | Callable[[Path], None]
    line: str
    record: str = ""
    exit_code: int = 3
    file: str = "day1.csv"


def damaged(write: Callable[[Path], None]) -> Callable[[Path], None]:
    """Half of a file."""

    def half(path: Path) -> None:
        write(path)
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])

    return half


def mat5(path: Path) -> None:
    savemat(path, good())


def hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        for name, values in good().items():
            file[name] = values


def mat73(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"] = good()["t"]
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + path.read_bytes()[512:])


def npz(path: Path) -> None:
    np.savez(path, **good())  # type: ignore[arg-type]


def pickled(path: Path) -> None:
    np.savez(path, t=np.array([{"not": "plain"}], dtype=object))


def lengths(path: Path) -> None:
    np.savez(path, **good() | {"tau_m": np.ones(7)})  # type: ignore[arg-type]


def matrix(path: Path) -> None:
    np.savez(path, **good() | {"joints": np.ones((100, 6))})  # type: ignore[arg-type]


def text_only(path: Path) -> None:
    savemat(path, {"comment": "nothing was recorded"})


FOREIGN = "save it again"
MEND = "correct or remove the line"

CASES = [
    Case("not_a_number", with_line(5, "0.03,1,oops,3"), f'FILE:5: "oops" is not a number; {MEND}'),
    Case("not_a_number_first", with_line(2, "0,one,2,3"), f'FILE:2: "one" is not a number; {MEND}'),
    Case(
        "not_a_number_after_comments",
        "# robot 7\n\n" + with_line(5, "0.03,1,oops,3"),
        f'FILE:7: "oops" is not a number; {MEND}',
    ),
    Case("row_short", with_line(9, "0.07,1,2"), f"FILE:9: 3 columns where the names promise 4; {MEND}"),
    Case("row_long", with_line(9, "0.07,1,2,3,4"), f"FILE:9: 5 columns where the names promise 4; {MEND}"),
    Case("decimal_comma", with_line(9, "0,07,1,2,3"), f"FILE:9: 5 columns where the names promise 4; {MEND}"),
    Case("empty", "", "FILE: the file is empty; record again, or name another file"),
    Case("blank", "\n\n  \n", "FILE: the file is empty; record again, or name another file"),
    Case(
        "names_only",
        "t,tau_m,phi_m\n",
        "FILE: there are names but no samples; record again, or name another file",
    ),
    Case(
        "no_names",
        "0,1,2\n0.01,1,2\n",
        "FILE: no column was found for tau_m; "
        "the file has no names: give the position under columns, such as tau_m: 0; they are 0 to 2",
        exit_code=2,
    ),
    Case(
        "name_twice",
        "t,tau_m,tau_m\n0,1,2\n",
        'FILE: two columns are called "tau_m", and differ; rename one; of several time columns, export one',
    ),
    Case(
        "not_text",
        lambda path: path.write_bytes(b"PK\x03\x04\x00\x00") and None,
        "FILE: this is not text; save it as CSV, or name it after its format",
    ),
    Case(
        "unknown_suffix",
        "t,tau_m\n",
        'FILE: no reader for the format ".xlsx"; export it as CSV, or name a file of '
        ".csv, .db3, .h5, .hdf5, .json, .jsonl, .lvm, .mat, .mcap, .mdf, .mf4, .ndjson, "
        ".npz, .parquet, .pq, .tsv, .txt",
        file="day1.xlsx",
    ),
    Case(
        "missing_file",
        lambda path: None,
        "FILE: there is no such file; a record's file is relative to the configuration",
    ),
    Case(
        "time_backward",
        csv(with_sample("t", 42, 0.1)),
        "FILE:44: time runs backward, from 0.41 to 0.1 s; sort the recording, or cut it there by start or stop",
    ),
    Case(
        "duplicates_differ",
        csv(with_sample("t", 42, 0.41)),
        "FILE:44: 1 sample repeats the time before it with other values; "
        "set repair: {duplicates: drop} to keep the first of each",
    ),
    Case(
        "duplicates_refused",
        csv({name: np.insert(values, 42, values[42]) for name, values in good().items()}),
        "FILE:45: 1 sample repeats the time before it; set repair: {duplicates: drop} to keep the first of each",
        record=", repair: {duplicates: refuse}",
    ),
    Case(
        "gap_long",
        csv(cut(49, 53)),
        "FILE: a gap before FILE:51 leaves no 50 samples in a row; record again, or set repair: {gaps: interpolate}",
    ),
    Case(
        "gap_long_refused",
        csv(cut(42, 46)),
        "FILE:44: 4 samples are missing before this one; "
        "cut the record there by start or stop, or set repair: {gaps: interpolate}",
        record=", repair: {gaps: refuse}",
    ),
    Case(
        "gap_refused",
        csv(cut(42, 43)),
        "FILE:44: 1 sample is missing before this one; "
        "cut the record there by start or stop, or set repair: {gaps: interpolate}",
        record=", repair: {gaps: refuse}",
    ),
    Case(
        "nan_long",
        csv(with_sample("tau_m", slice(30, 40), np.nan)),
        "FILE:32: tau_m is not a number in 10 samples, 10 of them in a row; "
        "record again, or set repair: {nan: interpolate}",
    ),
    Case(
        "nan_refused",
        csv(with_sample("phi_m", 30, np.inf)),
        "FILE:32: phi_m is not a number in 1 sample; record again, or set repair: {nan: interpolate}",
        record=", repair: {nan: refuse}",
    ),
    Case(
        "nan_mostly",
        csv(with_sample("tau_m", slice(10, 90), np.nan)),
        "FILE:12: tau_m is not a number in 80 of 100 samples; record again, or name another column",
        record=", repair: {nan: interpolate}",
    ),
    Case(
        "wrap_refused",
        csv(good() | {"phi_m": np.arange(100) * 0.3 % (2 * np.pi)}),
        "FILE:23: phi_m wraps around; set repair: {wrap: unwrap}",
        record=", repair: {wrap: refuse}",
    ),
    Case(
        "mostly_missing",
        csv({name: values[np.arange(240) % 9 < 3] for name, values in good(240).items()}),
        "FILE: 156 of 237 samples are missing between the others; record again at a rate that the logger keeps up with",
        record=", repair: {gaps: interpolate}",
    ),
    Case(
        "disturbance_of_an_angle",
        csv(good(), head="t,tau_m,phi_m,disturbance_deg"),
        "FILE, column disturbance_deg: disturbance cannot be in deg; give its unit, such as Nm, or another column",
        record=", columns: {disturbance: {name: disturbance_deg, unit: deg}}",
        exit_code=2,
    ),
    Case(
        "disturbance_missing",
        csv(good()),
        'FILE: there is no column "pulses"; it holds t, tau_m, phi_m, dphi_m',
        record=", columns: {disturbance: pulses}",
        exit_code=2,
    ),
    Case(
        "disturbance_in_volts",
        csv(good(), head="t,tau_m,phi_m,pulses_V"),
        "FILE, column pulses_V: disturbance is in V and needs a scale; "
        "write disturbance: {name: pulses_V, scale: ...} with the Nm per V",
        record=", columns: {disturbance: pulses_V}",
        exit_code=2,
    ),
    Case(
        "sampling_time_contradicts",
        csv(good()),
        "FILE: samples are 0.01 s apart, sampling_time says 0.001 s; "
        "give the time column's unit, or correct sampling_time",
        record=", sampling_time: 0.001, columns: {t: t}",
    ),
    Case(
        "time_stands",
        csv(good() | {"t": np.zeros(100)}),
        "FILE:3: 99 samples repeat the time before them with other values: time is written with too few digits; "
        "write t: null under columns and give sampling_time instead",
    ),
    Case(
        "time_stands_dropped",
        csv(good() | {"t": np.zeros(100)}),
        "FILE: there is a single sample; record longer",
        record=", repair: {duplicates: drop}",
    ),
    Case(
        "unit_unknown",
        csv(good()),
        'FILE, column phi_m: there is no unit "radd"; did you mean rad?',
        record=", columns: {phi_m: {name: phi_m, unit: radd}}",
        exit_code=2,
    ),
    Case(
        "unit_of_something_else",
        csv(good()),
        "FILE, column phi_m: phi_m cannot be in Nm; give its unit, such as rad, or another column",
        record=", columns: {phi_m: {name: phi_m, unit: Nm}}",
        exit_code=2,
    ),
    Case(
        "volts_without_scale",
        csv(good(), "t,u_volt,phi_m,dphi_m"),
        "FILE, column u_volt: tau_m is in V and needs a scale; "
        "write tau_m: {name: u_volt, scale: ...} with the Nm per V",
        record=", columns: {tau_m: u_volt}",
        exit_code=2,
    ),
    Case(
        "start_beyond_the_end",
        csv(good()),
        "FILE: no sample lies between start 2 s and stop; the record is 0.99 s long",
        record=", start: 2.0",
        exit_code=2,
    ),
    Case(
        "cut_too_short",
        csv(good()),
        "FILE: a record of 31 samples is too short, the least is 50; record longer",
        record=", start: 0.2, stop: 0.5",
    ),
    Case(
        "speed_delay_is_no_time",
        csv(good()),
        "day1: speed_delay is 80 samples, of 100; give samples, not a time",
        record=", speed_delay: 80",
        exit_code=2,
    ),
    Case(
        "turns_too_fast",
        csv(good() | {"phi_m": 2.9 * np.arange(100) % (2 * np.pi)}),
        "FILE:5: phi_m turns too far between samples to be unwrapped; "
        "record faster, or record an angle that does not wrap around",
    ),
    Case(
        "one_step_of_the_encoder",
        csv(good() | {"phi_m": 1e-3 * (np.arange(100) // 7 % 2)}),
        "FILE: the motor moves by 1 of its encoder's steps and no more; "
        "record a motion that excites the joint, or check the columns",
        record=", columns: {dphi_m: null}",
        exit_code=4,
    ),
    Case(
        "decimal_commas_throughout",
        "t,tau_m\n" + "0,01,1,5\n" * 60,
        "FILE:2: 4 columns where the names promise 2; put ; between the columns if , is the decimal mark",
    ),
    Case(
        "thousands_separator",
        csv(good()).replace(",", ";").replace("0.03;", "1.000,03;"),
        'FILE:5: "1.000,03" is not a number; correct or remove the line',
    ),
    Case(
        "column_of_text",
        "t,tau_m,phi_m\n" + "a quarter past eight,1,2\n" * 60,
        'FILE: column "t" holds text, such as "a quarter past eight"; '
        "name a column of numbers; for the time, sampling_time does as well",
        record=", columns: {t: t}",
        exit_code=2,
    ),
    Case(
        "time_of_day_that_stands_still",
        "t,tau_m,phi_m\n" + "08:15:01,1,2\n" * 60,
        "FILE: there is a single sample; record longer",
        record=", columns: {t: t}",
        exit_code=3,
    ),
    Case(
        "column_misspelt",
        csv(good()),
        'FILE: there is no column "tau_mm"; did you mean tau_m?',
        record=", columns: {tau_m: tau_mm}",
        exit_code=2,
    ),
    Case(
        "column_absent",
        csv(good()),
        'FILE: there is no column "torque"; it holds t, tau_m, phi_m, dphi_m',
        record=", columns: {tau_m: torque}",
        exit_code=2,
    ),
    Case(
        "nothing_called_torque",
        csv(good(), "t,a,phi_m,b"),
        "FILE: no column was found for tau_m; name it under columns: tau_m; it holds t, a, phi_m, b",
        exit_code=2,
    ),
    Case(
        "ambiguous",
        csv(good(), "t,tau,angle,position"),
        "FILE: angle and position could both be phi_m; say which under columns: phi_m",
        exit_code=2,
    ),
    Case(
        "no_time",
        csv(good(), "k,tau_m,phi_m,dphi_m"),
        "FILE: neither a time column nor a sampling time is known; "
        "name the time column under columns: t, or give sampling_time; it holds k, tau_m, phi_m, dphi_m",
        exit_code=2,
    ),
    Case(
        "torque_null",
        csv(good()),
        "FILE: no column was found for tau_m; name it under columns: tau_m; it holds t, tau_m, phi_m, dphi_m",
        record=", columns: {tau_m: null}",
        exit_code=2,
    ),
    Case(
        "matrix_without_column",
        matrix,
        'FILE: "joints" is a matrix of 6 columns; say which: {name: joints, column: 0}',
        record=", columns: {tau_m: joints}",
        exit_code=2,
        file="day1.npz",
    ),
    Case(
        "matrix_column_beyond",
        matrix,
        'FILE: "joints" has columns 0 to 5, not 6; columns are counted from 0',
        record=", columns: {tau_m: {name: joints, column: 6}}",
        exit_code=2,
        file="day1.npz",
    ),
    Case(
        "vector_with_column",
        matrix,
        'FILE: "phi_m" is a single column, not a matrix; leave out `column`',
        record=", columns: {phi_m: {name: phi_m, column: 1}}",
        exit_code=2,
        file="day1.npz",
    ),
    Case(
        "lengths_differ",
        lengths,
        "FILE: columns differ in length: t 100, tau_m 7, phi_m 100, dphi_m 100; name columns of one recording",
        file="day1.npz",
    ),
    Case(
        "npz_pickled",
        pickled,
        "FILE: this is not a readable NumPy archive: foreign, damaged, or with pickled objects; "
        "save plain arrays with numpy.savez",
        file="day1.npz",
    ),
    Case(
        "npz_damaged",
        damaged(npz),
        "FILE: this is not a readable NumPy archive: foreign, damaged, or with pickled objects; "
        "save plain arrays with numpy.savez",
        file="day1.npz",
    ),
    Case(
        "mat_damaged",
        damaged(mat5),
        f"FILE: this is not a readable MATLAB file: foreign or damaged; {FOREIGN}",
        file="day1.mat",
    ),
    Case(
        "mat73_damaged",
        damaged(mat73),
        f"FILE: this is not a readable MATLAB file: foreign or damaged; {FOREIGN}",
        file="day1.mat",
    ),
    Case(
        "mat_foreign",
        csv(good()),
        f"FILE: this is not a readable MATLAB file: foreign or damaged; {FOREIGN}",
        file="day1.mat",
    ),
    Case(
        "mat_without_numbers",
        text_only,
        "FILE: the file holds no numeric array of one or two dimensions; "
        "save plain arrays or structs of them; MATLAB's tables, timetables and timeseries cannot be read",
        file="day1.mat",
    ),
    Case(
        "h5_damaged",
        damaged(hdf5),
        f"FILE: this is not a readable HDF5 file: foreign or damaged; {FOREIGN}",
        file="day1.h5",
    ),
    Case("h5_empty", "", f"FILE: this is not a readable HDF5 file: foreign or damaged; {FOREIGN}", file="day1.h5"),
    Case(
        "too_short",
        csv(good(49)),
        "FILE: a record of 49 samples is too short, the least is 50; record longer",
    ),
    Case(
        "torque_constant",
        csv(good() | {"tau_m": np.full(100, 0.3)}),
        "FILE: the torque never changes; record a motion that excites the joint, or check the columns",
        exit_code=4,
    ),
    Case(
        "motor_stands",
        csv(good() | {"phi_m": np.ones(100)}),
        "FILE: the motor never moves; record a motion that excites the joint, or check the columns",
        exit_code=4,
    ),
]


def run(case: Case, folder: Path, options: list[str]) -> tuple[int, Path]:
    file, config = folder / case.file, folder / "axis.yaml"
    if isinstance(case.content, str):
        file.write_text(case.content, encoding="utf-8")
    else:
        case.content(file)
    config.write_text(CONFIG.format(file=case.file, record=case.record), encoding="utf-8")
    out = ["--out", str(folder / "run")]
    assert main(["excite", str(config), *out, "--quiet", "--json"]) == 0
    return main(["collect", str(config), *out, *options]), file


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_bad_file(case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, file = run(case, tmp_path, ["--quiet"])
    err = capsys.readouterr().err
    assert err == case.line.replace("FILE", str(file)) + "\n"
    assert code == case.exit_code
    assert not (tmp_path / "run" / "records.h5").exists()


def test_the_same_file_without_the_flaw_is_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _ = run(Case("good", csv(good()), ""), tmp_path, ["--quiet"])
    assert (code, capsys.readouterr().err) == (0, "")


@pytest.mark.parametrize(
    ("name", "repair", "count"),
    [
        ("gap_long", "gaps: interpolate", {"missing": 4}),
        ("nan_long", "nan: interpolate", {"not_finite": 10}),
        ("duplicates_differ", "duplicates: drop", {"duplicated": 1}),
    ],
)
def test_the_hint_helps(
    name: str, repair: str, count: dict[str, int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = next(case for case in CASES if case.name == name)
    mended = Case(name, case.content, "", record=f", repair: {{{repair}}}")
    code, _ = run(mended, tmp_path, ["--quiet", "--json"])
    out = capsys.readouterr().out
    assert code == 0
    told = json.loads(out[out.index('{\n  "records"') :])["records"]["day1"]["mended"]
    assert told.items() >= count.items()


@pytest.mark.parametrize("write", [mat5, mat73, hdf5, npz], ids=["mat5", "mat73", "hdf5", "npz"])
def test_no_damage_is_a_bug_of_ours(write: Callable[[Path], None], tmp_path: Path) -> None:
    """Files cut short or with wrong bytes are read or refused, never crash."""
    path = tmp_path / f"day1.{ {'mat5': 'mat', 'mat73': 'mat', 'hdf5': 'h5', 'npz': 'npz'}[write.__name__] }"
    write(path)
    assert times_refused(path, times=60, seed=1, head=1024) >= 20
