"""The shipped examples: they are whole, they load, they overwrite nothing, and a wheel holds them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from support.paths import ROOT

from robotid.cli import example
from robotid.cli.app import main
from robotid.config.load import load_robot

NAMES = [one.name for one in example.examples()]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def contents(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_a_configuration_that_loads_with_all_its_data(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["example", name]) == 0
    written = contents(Path(name))
    said = capsys.readouterr()
    assert sorted(said.out.split()) == sorted(str(Path(name) / path) for path in written)
    assert f"robotid run {Path(name) / name}.yaml" in said.err
    settings = next(iter(load_robot(Path(name) / f"{name}.yaml").values())).config
    files = [record.file for record in settings.records if record.file is not None]
    assert sorted(written) == sorted([f"{name}.yaml", *files])
    assert all(written[file] == (ROOT / file).read_bytes() for file in files)


def test_the_examples_are_listed_with_what_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["example"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in NAMES)
    assert main(["example", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert list(listed) == NAMES
    assert listed["demo"]["files"] == ["data/check.csv", "data/set1.csv", "data/set2.csv", "data/set3.csv", "demo.yaml"]
    assert all(one["summary"].endswith(".") for one in listed.values())


def test_nothing_is_overwritten(capsys: pytest.CaptureFixture[str]) -> None:
    Path("smoke").mkdir()
    Path("smoke/own.txt").write_text("mine")
    assert main(["example", "smoke"]) == 2
    assert "smoke: this folder or file exists" in capsys.readouterr().err
    assert contents(Path("smoke")) == {"own.txt": b"mine"}
    assert main(["example", "smoke", "other/place"]) == 0
    assert list(contents(Path("other"))) == ["place/smoke.yaml"]


def test_an_unknown_name_is_an_error_with_a_suggestion(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["example", "dmo"]) == 2
    assert 'no example "dmo"; did you mean demo?' in capsys.readouterr().err
    assert contents(Path()) == {}


def test_an_example_is_whole_or_absent(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write = Path.write_bytes
    monkeypatch.chdir(tmp_path)

    def full(path: Path, content: bytes) -> int:
        if path.name == "set2.csv":
            raise OSError(28, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    assert main(["example", "demo"]) == 3
    assert "demo: it cannot be written (No space left on device)" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_installation_is_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    Path("shipped").mkdir()
    monkeypatch.setattr(example, "SHIPPED", Path("shipped"))
    assert main(["example", "demo"]) == 3
    assert "demo.yaml: the installation lacks this file" in capsys.readouterr().err
    assert not Path("demo").exists()


def test_the_wheel_takes_every_file_of_every_example() -> None:
    """What the build configuration names, which a build of a wheel follows to the letter."""
    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    needed = {f"configs/{name}.yaml" for name in NAMES}
    for one in example.examples():
        needed |= {path for path in one.files() if path.startswith("data/")}
    assert set(wheel["only-include"]) == {"robotid", *needed}
    package = ROOT / "robotid"
    assert wheel["sources"] == {
        folder: (example.SHIPPED / folder).relative_to(package.parent).as_posix() for folder in ("configs", "data")
    }


def test_a_wheel_brings_an_example_that_runs(tmp_path: Path) -> None:
    pytest.importorskip("hatchling", reason="without the build backend there is no wheel to look into")
    built = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    pages = {page.name for page in (ROOT / "robotid" / "docs").glob("*.md")}
    assert {page.name for page in (tmp_path / "site" / "robotid" / "docs").iterdir()} == pages
    here = os.environ | {"PYTHONPATH": str(tmp_path / "site")}
    for words in (["example", "demo"], ["excite", "demo/demo.yaml"], ["collect", "demo/demo.yaml", "--json"]):
        command = [sys.executable, "-m", "robotid", *words]
        done = subprocess.run(command, cwd=tmp_path, env=here, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert {"set1", "set2", "set3", "check"} <= set(json.loads(done.stdout)["records"])
    assert (tmp_path / "demo" / "data" / "set1.csv").read_bytes() == (ROOT / "data" / "set1.csv").read_bytes()
