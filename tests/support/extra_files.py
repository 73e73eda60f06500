"""A recording in each of the formats that an extra reads, written by the format's own library.

A second of an inertia of 0.02 kg m2 that is swung to and fro: torque, angle and speed.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from robotid.model.array import Array

BEGIN = 1_700_000_000_123_456_789  # [ns] since 1970
STEP = 5_000_000  # [ns]
N = 200

Columns = dict[str, Array]


def motion(n: int = N, step: float = STEP * 1e-9) -> Columns:
    """Time stamps from the first sample [s], torque [Nm], angle [rad] and speed [rad/s], (n,) each."""
    t = np.arange(n) * step
    return {"t": t, "effort": -0.02 * 49 * np.sin(7 * t), "position": np.sin(7 * t), "velocity": 7 * np.cos(7 * t)}


def parquet(path: Path) -> None:
    """Nanoseconds since 1970 as timestamps, degrees by the metadata of the field, a struct."""
    pa = pytest.importorskip("pyarrow", reason="needs the extra parquet")
    import pyarrow.parquet as pq

    m = motion()
    angle = pa.field("angle", pa.float64(), metadata={"unit": "deg"})
    drive = pa.array([{"torque": x} for x in m["effort"]])
    stamps = pa.array(BEGIN + STEP * np.arange(N), pa.timestamp("ns"))
    schema = pa.schema([("time", stamps.type), angle, ("drive", drive.type)])
    pq.write_table(pa.table([stamps, pa.array(np.rad2deg(m["position"])), drive], schema=schema), path)


def stamps_of(k: int, begin: int = BEGIN) -> dict[str, int]:
    at = begin + k * STEP
    return {"sec": at // 10**9, "nanosec": at % 10**9}


JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def mcap(path: Path, compression: str = "ZSTD") -> None:
    """JointState, stamped evenly and logged a little late, with the second joint named first. compression : of chunks,
    "NONE", "LZ4" or "ZSTD"."""
    writer = pytest.importorskip("mcap_ros2.writer", reason="needs the extra mcap")
    from mcap.writer import CompressionType

    m = motion()
    with path.open("wb") as file, writer.Writer(file, compression=CompressionType[compression]) as bag:
        schema = bag.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for k in range(N):
            message = {
                "header": {"stamp": stamps_of(k), "frame_id": ""},
                "name": ["wrist", "elbow"],
                **{field: [0.0, float(m[field][k])] for field in ("position", "velocity", "effort")},
            }
            bag.write_message("/joint_states", schema, message, log_time=BEGIN + k * STEP + 100_000 * (1 + k % 3))


def mcap_json(path: Path, encoding: str = "json") -> None:
    """Angle and torque as topics of their own, the torque twice as often and a little earlier."""
    writer = pytest.importorskip("mcap.writer", reason="needs the extra mcap")
    slow, fast = motion(), motion(2 * N, 0.5e-9 * STEP)
    with path.open("wb") as file:
        bag = writer.Writer(file)
        bag.start()
        angle, torque = (bag.register_channel(topic, encoding, 0) for topic in ("/encoder", "/drive"))
        for k in range(2 * N):
            at, message = BEGIN + k * STEP // 2, {"torque": fast["effort"][k], "words": ["a", "b"]}
            bag.add_message(torque, at, json.dumps(message).encode(), at)
        for k in range(1, N):
            at, message = BEGIN + k * STEP, {"angle": {"value": slow["position"][k]}, "raw": [k] * 3}
            bag.add_message(angle, at, json.dumps(message).encode(), at)
        bag.finish()


def ros2_bag(path: Path) -> None:
    """JointState of two publishers on one topic, without torque, and the torque as an array without names."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="needs the extra rosbag")
    from rosbags.typesys import Stores, get_typestore

    store, m = get_typestore(Stores.ROS2_HUMBLE), motion()
    state, header, time = (
        store.types[name]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    many, layout = (store.types[f"std_msgs/msg/{name}"] for name in ("Float64MultiArray", "MultiArrayLayout"))
    with rosbag2.Writer(path.parent / "bag", version=8) as bag:
        states, efforts = (
            bag.add_connection(topic, kind.__msgtype__, typestore=store)
            for topic, kind in (("/joint_states", state), ("/efforts", many))
        )
        for k in range(N):
            now, empty = time(**stamps_of(k)), np.zeros(0)
            for name, x in (("elbow", m["position"][k]), ("gripper", 0.0)):
                message = state(header(now, ""), [name], np.array([x]), empty, empty)
                bag.write(states, BEGIN + k * STEP, store.serialize_cdr(message, state.__msgtype__))
            torque = many(layout([], 0), np.array([0.0, m["effort"][k]]))
            bag.write(efforts, BEGIN + k * STEP, store.serialize_cdr(torque, many.__msgtype__))
    (path.parent / "bag" / "bag.db3").rename(path)


DRIVE_STATE = """builtin_interfaces/Time stamp
geometry_msgs/Vector3 current
float32 torque
string mode
bool[2] limits
"""


def ros2_folder(folder: Path, storage: str, *, version: int = 9, compression: str = "") -> None:
    """JointState without efforts, and the torque in a message of a package that no other machine knows, in a bag as
    ROS 2 records one. storage : "SQLITE3" or "MCAP"; compression : "MESSAGE" or "FILE", none where empty."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="needs the extra rosbag")
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store, m, own = get_typestore(Stores.ROS2_HUMBLE), motion(), "lab_msgs/msg/DriveState"
    store.register(get_types_from_msg(DRIVE_STATE, own))
    names = ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time", own)
    state, header, time, drive = (store.types[name] for name in names)
    vector = store.types["geometry_msgs/msg/Vector3"]
    bag = rosbag2.Writer(folder, version=version, storage_plugin=rosbag2.StoragePlugin[storage])
    if compression:
        bag.set_compression(rosbag2.CompressionMode[compression], rosbag2.CompressionFormat.ZSTD)
    with bag:
        states, drives = (
            bag.add_connection(topic, name, typestore=store)
            for topic, name in (("/joint_states", names[0]), ("/drive", own))
        )
        for k in range(N):
            now, at = time(**stamps_of(k)), BEGIN + k * STEP + 100_000 * (1 + k % 3)
            x, v = (np.array([0.0, m[name][k]]) for name in ("position", "velocity"))
            message = state(header(now, ""), ["wrist", "elbow"], x, v, np.zeros(0))
            bag.write(states, at, store.serialize_cdr(message, names[0]))
            torque = drive(now, vector(1.0, 2.0, 3.0), float(m["effort"][k]), "on", np.array([True, False]))
            bag.write(drives, at, store.serialize_cdr(torque, own))


def mdf(path: Path) -> None:
    """Angle in degrees in one group, torque in another with time stamps of its own; words; a name that comes twice."""
    asammdf = pytest.importorskip("asammdf", reason="needs the extra mdf")
    slow, fast = motion(), motion(2 * N, 0.5e-9 * STEP)
    word = asammdf.Signal(np.array([b"on"] * N), 3 + slow["t"], name="state", encoding="utf-8")
    angle = asammdf.Signal(np.rad2deg(slow["position"]), 3 + slow["t"], name="Motor.angle", unit="deg")
    twice = [asammdf.Signal(np.ones(len(m["t"])), 3 + m["t"], name="temperature", unit="-") for m in (slow, fast)]
    torque = asammdf.Signal(1e3 * fast["effort"], 3 + fast["t"], name="Motor.torque", unit="mNm")
    with asammdf.MDF(version="4.10") as file:
        file.append([word, angle, twice[0]], acq_name="encoder")
        file.append([torque, twice[1]], acq_name="drive")
        file.save(path, overwrite=True)


WRITERS = {".parquet": parquet, ".mcap": mcap, ".db3": ros2_bag, ".mf4": mdf}
