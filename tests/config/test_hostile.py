"""Configurations that are small and mean much, or mean nothing: one line, soon."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotid.config.load import load, parse
from robotid.config.tree import MAX_DEPTH, MAX_NODES, compose
from robotid.errors import ConfigError


@pytest.fixture(autouse=True)
def quick() -> Iterator[None]:
    began = time.monotonic()
    yield
    assert time.monotonic() - began < 10


def laughs(first: str, many: str) -> str:
    """Aliases of aliases: ten to the ninth entries."""
    lines = [f"a0: &a0 {first}"]
    lines += [f"a{k}: &a{k} " + many.format(", ".join([f"*a{k - 1}"] * 10)) for k in range(1, 10)]
    return "\n".join(lines)


BOMBS = {
    "lists": laughs("[x, x]", "[{}]"),
    "merges": laughs("{x: 1}", "{{<<: [{}]}}"),
    "mappings": "a0: &a0 {x: 1}\n" + "\n".join(f"a{k}: &a{k} {{x: *a{k - 1}, y: *a{k - 1}}}" for k in range(1, 40)),
    "depth of lists": "robot: " + "[" * 2000 + "]" * 2000,
    "depth of mappings": "robot: " + "{a: " * 2000 + "}" * 2000,
    "depth by indent": "\n".join(" " * k + "a:" for k in range(2000)),
    "wide": "robot: [" + "x, " * (MAX_NODES + 1) + "]",
}


@pytest.mark.parametrize("text", BOMBS.values(), ids=BOMBS)
def test_bombs(text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse(text)
    assert len(str(caught.value)) < 300


def test_aliases_that_mean_little_are_welcome() -> None:
    node = compose("a: &a {x: 1}\nb: [*a, *a]\nc: {<<: *a, y: 2}", "a.yaml")
    assert node is not None
    deep = "[" * (MAX_DEPTH - 1) + "]" * (MAX_DEPTH - 1)
    assert compose(deep, "a.yaml") is not None


MEANINGLESS = {
    "robot: !!int abc": '"abc" is no !!int',
    "robot: !!float 1.2.3": '"1.2.3" is no !!float',
    "robot: !!bool maybe": '"maybe" is no !!bool',
    "robot: !!null x": '"x" is no !!null',
    "robot: !!map x": '"x" is no !!map',
    "robot: !!seq x": '"x" is no !!seq',
    "robot: " + "9" * 5000: "a number of 5000 digits",
    "robot: 1" + "0" * 5000 + ".5": "a number of 5003 digits",
    'robot: "\\e[31m"': "a control character",
    'robot: "\\0"': "a control character",
    'robot: "\\uDCFF"': "a control character",
    '"a\\x07": 1': "a control character",
    'robot: "\\UFFFFFFFF"': "this is not YAML",
    "%YAML " + "9" * 5000 + ".1\n---\na: 1": "this is not YAML",
    "a: 1\na: 2": 'key "a" stands twice, first on line 1',
    "? [a]\n: 1": "a key must be a word",
    "a: &a [*a]": "an alias stands inside its own anchor",
    "a: &a {<<: *a}": "an alias stands inside its own anchor",
    "<<: 3": "<< takes a mapping",
    "<<: [{a: 1}, 3]": "<< takes a mapping",
    "a: !!python/object/apply:os.system [ls]": "YAML tags such as",
}


@pytest.mark.parametrize(("text", "message"), MEANINGLESS.items(), ids=range(len(MEANINGLESS)))
def test_what_means_nothing(text: str, message: str) -> None:
    with pytest.raises(ConfigError, match=r"^configuration(:[0-9:]+)?: ") as caught:
        parse(text)
    assert message in str(caught.value)
    assert str(caught.value).isprintable()


def test_a_large_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    with path.open("wb") as file:
        file.truncate(100_000_000)
    with pytest.raises(ConfigError, match="larger than 500 kB, which no configuration is"):
        load(path)
    path.write_bytes(b"\xff" * 600_000)
    with pytest.raises(ConfigError, match="larger than 500 kB"):
        load(path)
