"""Files that declare what nobody can hold, lead in circles, or point at the files of others."""

from __future__ import annotations

import io
import json
import struct
import time
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from robotid.errors import InputError
from robotid.signals.columns import find
from robotid.signals.proposal import propose
from robotid.signals.readers import read
from robotid.signals.readers.room import available_memory, in_words, require_room

TORQUE = np.sin(np.arange(100.0))
HUGE = 2**37  # samples: 1.1 TB of floats


@pytest.fixture(autouse=True)
def quick() -> Iterator[None]:
    began = time.process_time()
    yield
    assert time.process_time() - began < 10


def fill(file: h5py.File) -> None:
    """A recording, and beside it a dataset of a terabyte that was declared and never written."""
    file["torque"], file["angle"] = TORQUE, np.cumsum(TORQUE)
    file.create_dataset("speed", (HUGE,), "f8", chunks=(1024,))


@pytest.mark.parametrize("suffix", [".h5", ".mat"])
def test_a_bomb_beside_the_columns_asked_for_is_not_read(suffix: str, tmp_path: Path) -> None:
    with h5py.File(tmp_path / f"log{suffix}", "w") as file:
        fill(file)
    table = read(tmp_path / f"log{suffix}")
    assert np.array_equal(table.pick("torque"), TORQUE)
    assert table.shape("speed") == (HUGE,)
    column = find(table, "dphi_m")
    assert column is not None
    with pytest.raises(InputError, match=r"speed declares 1\.1 TB in a file of \d+(\.\d+)? kB: that is no recording"):
        table.pick("speed")


def test_packed_zeros_in_hdf5(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file.create_dataset("torque", data=np.zeros(2**24), chunks=(2**20,), compression="gzip", compression_opts=9)
    with pytest.raises(InputError, match="torque declares 134 MB"):
        read(tmp_path / "log.h5").pick("torque")


def test_an_npz_member_that_declares_too_much(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "log.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        for name, shape in (("torque", (100,)), ("speed", (HUGE,)), ("more", (2**62, 2**62))):
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array_header_1_0(member, {"descr": "<f8", "fortran_order": False, "shape": shape})
                member.write(TORQUE.tobytes())
        archive.writestr("readme.txt", "no array")
        archive.writestr("empty.npy", b"")
    with pytest.raises(InputError, match="not a readable NumPy archive"):
        read(tmp_path / "log.npz")
    image = io.BytesIO()
    with zipfile.ZipFile(tmp_path / "log.npz") as before, zipfile.ZipFile(image, "w") as after:
        for info in before.infolist():
            if info.filename != "empty.npy":
                after.writestr(info.filename, before.read(info))
    (tmp_path / "log.npz").write_bytes(image.getvalue())
    table = read(tmp_path / "log.npz")
    assert sorted(table.columns) == ["more", "speed", "torque"]
    assert np.array_equal(table.pick("torque"), TORQUE)
    for name in ("speed", "more"):
        with pytest.raises(InputError, match=f"{name} declares .* TB in a file"):
            _ = table.columns[name]


def test_members_that_are_no_plain_arrays_are_passed_over(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", torque=TORQUE, notes=np.array([{"a": 1}], dtype=object), words=np.array(["a"]))
    assert list(read(tmp_path / "log.npz").columns) == ["torque"]


def test_a_packed_variable_of_matlab_that_declares_too_much(tmp_path: Path) -> None:
    savemat(tmp_path / "log.mat", {"torque": TORQUE})
    plain = (tmp_path / "log.mat").read_bytes()
    zeros = zlib.compress(struct.pack("<2I", 14, 2**31) + bytes(1000))
    (tmp_path / "log.mat").write_bytes(plain + struct.pack("<2I", 15, len(zeros)) + zeros)
    with pytest.raises(InputError, match=r"it declares 2\.15 GB in a file of"):
        read(tmp_path / "log.mat")


def test_a_packed_variable_of_matlab_that_holds_more_than_it_declares(tmp_path: Path) -> None:
    savemat(tmp_path / "log.mat", {"torque": TORQUE}, do_compression=True)
    assert np.array_equal(read(tmp_path / "log.mat").pick("torque"), TORQUE)
    plain = (tmp_path / "log.mat").read_bytes()
    zeros = zlib.compress(struct.pack("<2I", 14, 1000) + bytes(10_000_000))
    (tmp_path / "log.mat").write_bytes(plain + struct.pack("<2I", 15, len(zeros)) + zeros)
    with pytest.raises(InputError, match="a variable holds more than it declares"):
        read(tmp_path / "log.mat")


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_matrix_of_matlab_4_that_declares_too_much(order: str, tmp_path: Path) -> None:
    savemat(tmp_path / "log.mat", {"torque": TORQUE, "angle": np.cumsum(TORQUE)}, format="4")
    assert np.array_equal(read(tmp_path / "log.mat").pick("torque"), TORQUE)
    header = struct.pack(f"{order}5I", 0 if order == "<" else 1000, 2**20, 2**10, 0, 2) + b"a\0"
    (tmp_path / "log.mat").write_bytes(header + TORQUE.tobytes())
    with pytest.raises(InputError, match=r"it declares 8\.59 GB in a file of 822 bytes"):
        read(tmp_path / "log.mat")


def test_chunks_of_mcap_that_unpack_to_too_much(tmp_path: Path) -> None:
    writing = pytest.importorskip("mcap.writer", reason="needs the extra mcap")
    for suffix, padding in (("small", 100), ("large", 70_000_000)):
        with (tmp_path / f"{suffix}.mcap").open("wb") as file:
            writer = writing.Writer(file, compression=writing.CompressionType.ZSTD)
            writer.start()
            schema = writer.register_schema("drive", "jsonschema", b"{}")
            channel = writer.register_channel("drive", "json", schema)
            for k, torque in enumerate(TORQUE[:3]):
                text = json.dumps({"torque": torque}).encode() + b" " * padding
                writer.add_message(channel, log_time=k, publish_time=k, data=text)
            writer.finish()
    assert len(read(tmp_path / "small.mcap").pick("drive.torque")) == 3
    with pytest.raises(InputError, match=r"it declares 70 MB in a file of [\d.]+ kB: that is no recording"):
        read(tmp_path / "large.mcap")


def test_a_group_of_mdf_that_declares_too_much(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="needs the extra mdf")
    path = tmp_path / "log.mf4"
    with asammdf.MDF() as file:
        t = np.arange(2**23) * 1e-3
        file.append([asammdf.Signal(np.zeros(len(t)), t, name="torque")])
        file.save(path, compression=2)
    with pytest.raises(InputError, match=r"declares 134 MB in a file of [\d.]+ kB: that is no recording"):
        read(path)


def test_values_in_other_files_are_refused(tmp_path: Path) -> None:
    secret = tmp_path / "secret.txt"
    secret.write_bytes(TORQUE.tobytes())
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["torque"] = TORQUE
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file.create_dataset("stored", (100,), "f8", external=[(str(secret), 0, 800)])
        virtual = h5py.VirtualLayout((100,), "f8")
        virtual[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "torque", (100,))
        file.create_virtual_dataset("virtual", virtual)
        file["linked"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "torque")
        file["torque"] = TORQUE
    for suffix in (".h5", ".mat"):
        path = (tmp_path / "log.h5").rename(tmp_path / f"log{suffix}") if suffix != ".h5" else tmp_path / "log.h5"
        table = read(path)
        assert np.array_equal(table.pick("torque"), TORQUE)
        assert "linked" not in table.columns
        for name in ("stored", "virtual"):
            with pytest.raises(InputError, match=f"the values of {name} lie in another file; copy them"):
                table.pick(name)


@pytest.mark.parametrize("suffix", [".h5", ".mat"])
def test_links_that_lead_in_circles(suffix: str, tmp_path: Path) -> None:
    with h5py.File(tmp_path / f"log{suffix}", "w") as file:
        file["torque"] = TORQUE
        group = file.create_group("a")
        for name in "bcdef":
            group[name] = group
        file["soft"] = h5py.SoftLink("/soft")
        file["a/g"] = h5py.SoftLink("/a")
        cell = file.create_dataset("cell", (2,), h5py.ref_dtype)
        cell[:] = [cell.ref, file["torque"].ref]
    table = read(tmp_path / f"log{suffix}")
    assert np.array_equal(table.pick("torque"), TORQUE)
    assert len(table.columns) < 100


def test_names_that_would_steer_a_terminal_are_written_out(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["torque\x1b[31m\n"] = TORQUE
        file["torque\x1b[31m\n"].attrs["unit"] = "Nm"
    table = read(tmp_path / "log.h5")
    assert list(table.columns) == ["torque\\x1b[31m\\n"]
    assert table.units == {"torque\\x1b[31m\\n": "Nm"}
    (tmp_path / "log.csv").write_text("t,a\x1b[31mb\n" + "1,2\n" * 9)
    assert list(read(tmp_path / "log.csv").columns) == ["t", "a\\x1b[31mb"]


def test_a_guess_reads_no_column_but_the_time(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["time"] = np.arange(100) * 0.01
        for name in ("torque", "angle"):
            file.create_dataset(name, (100,), "f8", external=[(str(tmp_path / "absent"), 0, 800)])
    found = propose(tmp_path / "log.h5")
    assert {signal: column.name for signal, column in found.columns.items()} == {
        "t": "time",
        "tau_m": "torque",
        "phi_m": "angle",
    }


def test_what_is_larger_than_the_memory_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "log.h5"
    path.write_bytes(bytes(2_000_000))
    require_room(path, "torque", 300_000_000)
    monkeypatch.setattr("robotid.signals.readers.room.available_memory", lambda: 1_000_000_000)
    with pytest.raises(InputError, match=r"torque takes 300 MB, and 1 GB of memory are free; cut the recording"):
        require_room(path, "torque", 300_000_000)
    assert available_memory() > 2**26
    assert in_words(5.12e9) == "5.12 GB"
