"""Formats that an optional extra reads: columns, units, time stamps to the nanosecond, and what to do without it."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support import extra_files
from support.damaged_file import times_refused
from support.extra_files import BEGIN, STEP, WRITERS, N, motion

from robotid.cli.app import main
from robotid.cli.perform import open_run
from robotid.errors import InputError
from robotid.pipeline.execute import execute
from robotid.signals.plausibility import Axis, check_records
from robotid.signals.quality import Recordings, inspect
from robotid.signals.readers import read
from robotid.signals.readers.table import Table
from robotid.signals.record import Record

M = motion()

CONFIG = """
robot: {{name: axis, model: {{motor: [inertia, viscous, coulomb]}}}}
records:
  - {{name: day1, file: {file}{columns}}}
"""


def collect(config: Path, *options: str) -> int:
    out = config.with_suffix("")
    execute(open_run(config, out, []), "excite")
    return main(["collect", str(config), "--out", str(out), "--quiet", *options])


def test_parquet(tmp_path: Path) -> None:
    extra_files.parquet(tmp_path / "a.parquet")
    table = read(tmp_path / "a.parquet")
    assert list(table.columns) == ["time", "angle", "drive.torque"]
    assert table.units == {"time": "s", "angle": "deg"}
    np.testing.assert_allclose(table.columns["time"], M["t"], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(table.columns["drive.torque"], M["effort"])


def test_parquet_of_every_type(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow", reason="needs the extra parquet")
    import pyarrow.parquet as pq

    columns = {
        "ns": pa.array([BEGIN, BEGIN + 1, None], pa.int64()),
        "unsigned": pa.array([2**64 - 3, 2**64 - 2, 2**64 - 1], pa.uint64()),
        "count": pa.array([5, None, 7], pa.int32()),
        "since": pa.array([1500, 2500, 3500], pa.duration("us")),
        "clock": pa.array([1000, 1001, 1002], pa.time32("ms")),
        "day": pa.array([0, 1, 2], pa.date32()),
        "on": pa.array([True, False, None]),
        "exact": pa.array([1, 2, 3]).cast(pa.decimal128(25, 2)),
        "pair": pa.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]),
        "fixed": pa.array([[1, 2], [3, 4], [5, 6]], pa.list_(pa.int16(), 2)),
        "ragged": pa.array([[1.0], [3.0, 4.0], []]),
        "word": pa.array([None, "hot", "cold"]).dictionary_encode(),
        "nothing": pa.nulls(3),
    }
    pq.write_table(pa.table(columns), tmp_path / "a.pq")
    table = read(tmp_path / "a.pq")
    expected = {
        "ns": [0, 1, np.nan],
        "unsigned": [0, 1, 2],
        "count": [5, np.nan, 7],
        "since": [0, 1e-3, 2e-3],
        "clock": [0, 1e-3, 2e-3],
        "day": [0, 86400, 2 * 86400],
        "on": [1, 0, np.nan],
        "exact": [1, 2, 3],
        "pair": [[1, 2], [3, 4], [5, 6]],
        "fixed": [[1, 2], [3, 4], [5, 6]],
    }
    assert set(table.columns) == set(expected)
    for name, values in expected.items():
        np.testing.assert_array_equal(table.columns[name], values, err_msg=name)
    assert table.text == {"word": "hot"}
    assert table.units == dict.fromkeys(("since", "clock", "day"), "s")
    np.testing.assert_array_equal(table.pick("pair[1]"), [2, 4, 6])


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_joints_go_by_their_names(compression: str, tmp_path: Path) -> None:
    extra_files.mcap(tmp_path / "a.mcap", compression)
    assert (compression.lower().encode() in (tmp_path / "a.mcap").read_bytes()) is (compression != "NONE")
    table = read(tmp_path / "a.mcap")
    joints = {f"/joint_states.{joint}.{field}" for joint in ("wrist", "elbow") for field in M if field != "t"}
    assert set(table.columns) == joints | {"/joint_states.t"}
    np.testing.assert_array_equal(table.columns["/joint_states.elbow.position"], M["position"])
    step = np.diff(table.columns["/joint_states.t"])
    np.testing.assert_allclose(step, STEP * 1e-9, rtol=0, atol=1e-12, err_msg="stamps of the header, to the nanosecond")


def test_topics_have_time_stamps_of_their_own(tmp_path: Path) -> None:
    extra_files.mcap_json(tmp_path / "a.mcap")
    table = read(tmp_path / "a.mcap")
    raw = {f"/encoder.raw[{i}]" for i in range(3)}
    assert set(table.columns) == {"/drive.t", "/drive.torque", "/encoder.t", "/encoder.angle.value"} | raw
    np.testing.assert_allclose(table.columns["/encoder.t"], M["t"][1:], rtol=0, atol=1e-12)
    assert table.clocks["/drive.torque"] == "/drive.t"
    assert table.units == {"/drive.t": "s", "/encoder.t": "s"}


def test_publishers_that_share_a_topic(tmp_path: Path) -> None:
    extra_files.ros2_bag(tmp_path / "a.db3")
    table = read(tmp_path / "a.db3")
    elbow = "/joint_states.elbow.position"
    assert {elbow, "/joint_states.gripper.position", "/efforts.data[0]", "/efforts.data[1]"} <= set(table.columns)
    assert table.clocks[elbow] == f"{elbow}.t"
    np.testing.assert_array_equal(table.columns[elbow], M["position"])
    np.testing.assert_allclose(table.columns[f"{elbow}.t"], M["t"], rtol=0, atol=1e-12)


def test_groups_of_mdf(tmp_path: Path) -> None:
    extra_files.mdf(tmp_path / "a.mf4")
    table = read(tmp_path / "a.mf4")
    channels = {"Motor.angle", "Motor.torque", "encoder.temperature", "drive.temperature"}
    assert set(table.columns) == channels | {"encoder.time", "drive.time"}
    assert table.units["Motor.angle"] == "deg"
    assert "encoder.temperature" not in table.units
    assert table.text == {"state": "on"}
    assert table.clocks["Motor.torque"] == "drive.time"
    np.testing.assert_allclose(table.columns["Motor.torque"], 1e3 * motion(2 * N, 0.5e-9 * STEP)["effort"])


def test_samples_that_mdf_marks_as_invalid(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="needs the extra mdf")
    bad = np.arange(N) == 7
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(M["position"], M["t"], name="angle", invalidation_bits=bad)])
        file.save(tmp_path / "a.mf4", overwrite=True)
    table = read(tmp_path / "a.mf4")
    np.testing.assert_array_equal(np.isnan(table.columns["angle"]), bad)
    assert set(table.clocks.values()) == {"time"}


TOLD = {
    "torque": "tau_m has time stamps of its own, /drive.t: it is held onto /encoder.t",
    "group": "tau_m has time stamps of its own, drive.time: it is held onto encoder.time",
    "efforts": "tau_m has time stamps of its own, /efforts.t: it is held onto /joint_states.elbow.position.t",
}


@pytest.mark.parametrize(
    ("file", "write", "columns", "remark"),
    [
        ("a.parquet", extra_files.parquet, "", ""),
        (
            "a.mcap",
            extra_files.mcap,
            "{tau_m: /joint_states.elbow.effort, phi_m: /joint_states.elbow.position, "
            "dphi_m: /joint_states.elbow.velocity}",
            "",
        ),
        ("a.mcap", extra_files.mcap_json, "{tau_m: /drive.torque, phi_m: /encoder.angle.value}", TOLD["torque"]),
        ("a.mf4", extra_files.mdf, "", TOLD["group"]),
        (
            "a.db3",
            extra_files.ros2_bag,
            "{tau_m: '/efforts.data[1]', phi_m: /joint_states.elbow.position, dphi_m: null}",
            TOLD["efforts"],
        ),
    ],
    ids=["parquet", "mcap", "json", "mdf", "ros2"],
)
def test_a_record_comes_of_it(
    file: str,
    write: Callable[[Path], None],
    columns: str,
    remark: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / file)
    text = CONFIG.format(file=file, columns=f", columns: {columns}" if columns else "")
    (tmp_path / "a.yaml").write_text(text)
    code = collect(tmp_path / "a.yaml", "--json")
    out, err = capsys.readouterr()
    assert code == 0, err
    report = json.loads(out)["records"]["day1"]
    assert report["sampling_time"] == pytest.approx(STEP * 1e-9, rel=1e-9)
    assert report["samples"] in (N - 1, N)
    assert report["torque_range"] == pytest.approx([-0.98, 0.98], rel=1e-3)
    assert report["angle_range"] == pytest.approx([-1, 1], rel=1e-3)
    assert report["speed_range"] == pytest.approx([-7, 7], rel=1e-2)
    own = [remark for remark in report["remarks"] if "time stamps" in remark]
    assert own == ([remark] if remark else [])


@pytest.mark.parametrize("suffix", [".mcap", ".mf4"])
def test_a_configuration_is_drafted_from_it(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    WRITERS[suffix](tmp_path / f"log{suffix}")
    assert main(["new", "mine", "--from-data", f"log{suffix}"]) == 0
    capsys.readouterr()
    assert collect(tmp_path / "mine.yaml", "--json") == 0
    assert json.loads(capsys.readouterr().out)["records"]["log"]["samples"] == N
    if suffix == ".mcap":  # the wrist is first, and rests
        assert (
            "/joint_states.wrist.position could also be phi_m, and never changes"
            in (tmp_path / "mine.yaml").read_text()
        )


@pytest.mark.parametrize(
    ("samples", "viscous", "finding"),
    [(N, 0.0, "torque_follows"), (10 * N, 0.05, "torque_unrelated")],
)
def test_one_sine_wave_is_remarked_and_not_refused(samples: int, viscous: float, finding: str) -> None:
    m = motion(samples)
    torque = m["effort"] + viscous * m["velocity"]
    one = Record.from_arrays(torque, m["position"], STEP * 1e-9, speed=m["velocity"], name="log")
    found = check_records(Recordings((one,), (inspect(one, "log"),)), Axis()).findings
    assert [(f.name, f.severity) for f in found] == [(finding, "warning")]


def test_the_folder_of_a_bag_is_read(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    folder.mkdir()
    WRITERS[".mcap"](folder / "bag_0.mcap")
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {version: 8}")
    assert set(read(folder).columns) == set(read(folder / "bag_0.mcap").columns)
    config = tmp_path / "axis.yaml"
    config.write_text("""
robot: {name: axis, model: {motor: [inertia]}}
records:
  - name: log
    file: bag
    columns: {tau_m: /joint_states.elbow.effort, phi_m: /joint_states.elbow.position, dphi_m: null}
""")
    assert main(["collect", str(config), "--out", str(tmp_path / "run"), "--quiet"]) == 0


BAGS = [("SQLITE3", 8, ""), *[(storage, 9, how) for storage in ("SQLITE3", "MCAP") for how in ("", "MESSAGE", "FILE")]]


@pytest.mark.parametrize(("storage", "version", "compression"), BAGS)
def test_a_bag_as_ros_2_records_one(storage: str, version: int, compression: str, tmp_path: Path) -> None:
    """JointState, and a message of a package that only the bag knows, from the folder to a record."""
    extra_files.ros2_folder(tmp_path / "bag", storage, version=version, compression=compression)
    table = read(tmp_path / "bag")
    names = {"/joint_states.elbow.position", "/joint_states.wrist.velocity", "/drive.torque", "/drive.current.y"}
    assert names <= set(table.columns)
    assert table.clocks["/drive.torque"] == "/drive.t"
    stamps = table.columns["/joint_states.t"]
    np.testing.assert_allclose(stamps - stamps[0], M["t"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(table.columns["/drive.torque"], M["effort"], rtol=1e-6, atol=1e-6)
    config = tmp_path / "axis.yaml"
    config.write_text("""
robot: {name: axis, model: {motor: [inertia]}}
records:
  - {name: log, file: bag, columns: {tau_m: /drive.torque, phi_m: /joint_states.elbow.position, dphi_m: null}}
""")
    assert main(["collect", str(config), "--out", str(tmp_path / "run"), "--quiet"]) == 0


def test_a_compressed_file_of_a_bag_asks_for_its_folder(tmp_path: Path) -> None:
    extra_files.ros2_folder(tmp_path / "bag", "MCAP", compression="FILE")
    with pytest.raises(InputError, match=r"a compressed file of a ROS 2 bag; name its folder"):
        read(tmp_path / "bag" / "bag.mcap.zstd")


@pytest.mark.parametrize("damage", ["cut", "emptied", "overwritten", "no metadata", "foreign metadata", "lost file"])
@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_broken_bag_is_one_line(
    storage: str, damage: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    extra_files.ros2_folder(tmp_path / "bag", storage)
    (file,) = (path for path in (tmp_path / "bag").iterdir() if path.suffix in (".db3", ".mcap"))
    content = file.read_bytes()
    if damage == "cut":
        file.write_bytes(content[: len(content) // 3])
    elif damage == "emptied":
        file.write_bytes(b"")
    elif damage == "overwritten":
        file.write_bytes(content[:1000] + bytes(len(content) // 2) + content[1000 + len(content) // 2 :])
    elif damage == "lost file":
        file.unlink()
    elif damage == "no metadata":
        (tmp_path / "bag" / "metadata.yaml").unlink()
    else:
        (file.parent / f"{file.stem}_1{file.suffix}").write_bytes(content)
        (tmp_path / "bag" / "metadata.yaml").write_text("rosbag2_bagfile_information: [1, {")
    config = tmp_path / "axis.yaml"
    config.write_text("""
robot: {name: axis, model: {motor: [inertia]}}
records: [{name: log, file: bag, columns: {tau_m: /drive.torque, phi_m: /joint_states.elbow.position, dphi_m: null}}]
""")
    assert main(["collect", str(config), "--out", str(tmp_path / "run"), "--quiet"]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(str(tmp_path / "bag"))
    assert "; " in line
    assert not (tmp_path / "run" / "records.h5").exists()


def test_a_folder_without_a_bag(tmp_path: Path) -> None:
    (tmp_path / "metadata.yaml").write_text("no bag")
    with pytest.raises(InputError, match="this is a folder, and no ROS 2 bag"):
        read(tmp_path)


@pytest.mark.parametrize(
    ("suffix", "module", "name", "extra"),
    [
        (".parquet", "pyarrow.parquet", "pyarrow", "parquet"),
        (".mcap", "mcap.reader", "mcap", "mcap"),
        (".mcap", "mcap_ros2.decoder", "mcap_ros2", "mcap"),
        (".db3", "rosbags.highlevel", "rosbags", "rosbag"),
        (".mf4", "asammdf", "asammdf", "mdf"),
    ],
)
def test_without_the_extra_one_line_says_what_to_install(
    suffix: str,
    module: str,
    name: str,
    extra: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for package in ("mcap", "mcap.reader", "mcap_ros2", "mcap_ros2.decoder"):
        monkeypatch.setitem(sys.modules, package, sys.modules[__name__])  # whether installed or not
    monkeypatch.setitem(sys.modules, module, None)
    file = tmp_path / f"a{suffix}"
    file.write_bytes(b"whatever it holds")
    (tmp_path / "a.yaml").write_text(CONFIG.format(file=file.name, columns=""))
    assert collect(tmp_path / "a.yaml") == 3
    what = f"to read {suffix} files, {name} must be installed; pip install 'robotid[{extra}]'"
    assert capsys.readouterr() == ("", f"{file}: {what}\n")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # of asammdf's half-made objects
@pytest.mark.parametrize("suffix", WRITERS)
def test_no_damage_is_a_bug_of_ours(suffix: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Files cut short or with wrong bytes are read or refused, never crash."""
    path = tmp_path / f"day1{suffix}"
    WRITERS[suffix](path)
    assert times_refused(path, times=20, seed=2, head=512) >= 5
    assert capfd.readouterr() == ("", "")


def test_messages_that_nobody_can_decode(tmp_path: Path) -> None:
    extra_files.mcap_json(tmp_path / "a.mcap", encoding="protobuf")
    with pytest.raises(InputError, match="messages that are encoded as protobuf; convert it"):
        read(tmp_path / "a.mcap")


def test_recordings_that_do_not_overlap(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asammdf = pytest.importorskip("asammdf", reason="needs the extra mdf")
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(M["position"], M["t"], name="angle")], acq_name="first")
        file.append([asammdf.Signal(M["effort"], M["t"] + 100, name="torque")], acq_name="second")
        file.save(tmp_path / "a.mf4", overwrite=True)
    (tmp_path / "a.yaml").write_text(CONFIG.format(file="a.mf4", columns=""))
    assert collect(tmp_path / "a.yaml") == 3
    assert "a.mf4: torque and first.time were not recorded at the same time; name columns" in capsys.readouterr().err


def test_an_absent_column_is_answered_with_what_there_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    extra_files.mcap_json(tmp_path / "a.mcap")
    columns = ", columns: {tau_m: /drive.current, phi_m: /encoder.angle.value}"
    (tmp_path / "a.yaml").write_text(CONFIG.format(file="a.mcap", columns=columns))
    assert collect(tmp_path / "a.yaml") == 2
    assert 'there is no column "/drive.current"; ' in capsys.readouterr().err


def test_nanoseconds_in_plain_arrays_are_exact(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=BEGIN + np.arange(5), u=np.arange(5, dtype=np.uint64) + 2**63, k=np.arange(5))
    table: Table = read(tmp_path / "a.npz")
    for name in ("t", "u", "k"):
        np.testing.assert_array_equal(table.columns[name], np.arange(5), err_msg=name)


def test_a_folder_is_no_recording(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"this is a folder, and no ROS 2 bag; name a file, or the folder of a ROS 2 bag"
    ):
        read(tmp_path)
