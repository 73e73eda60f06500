"""MCAP files, by the format's own library: ROS 2 messages, and those in JSON. Columns are named as messages.py says."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from robotid.errors import InputError
from robotid.signals.readers.extra import library
from robotid.signals.readers.messages import Message, from_messages
from robotid.signals.readers.room import require_room
from robotid.signals.readers.table import Table

SUFFIXES = (".mcap",)

Decode = Callable[[bytes], Any]


def read(path: Path) -> Table:
    """Every number of every topic that can be decoded.

    Raises InputError for a damaged file, for one that declares more than there is room for, for one without such a
    topic, and where the library is not installed.
    """
    reader, ros2 = library("mcap.reader", "mcap", path), library("mcap_ros2.decoder", "mcap", path)
    unknown: set[str] = set()
    try:
        with path.open("rb") as file:
            _require_room(path, file)
            return from_messages(str(path), _messages(reader.make_reader(file), ros2.DecoderFactory(), unknown))
    except InputError as error:
        if not unknown:
            raise
        what = f"it holds no numbers but in messages that are encoded as {', '.join(sorted(unknown))}"
        hint = "convert it: ROS 2 messages (cdr) and json can be read"
        raise InputError(what, where=str(path), hint=hint) from error
    except Exception as error:  # a damaged file makes the parser fail in ways that nobody has listed
        what = "this is not a readable MCAP file: foreign or damaged"
        raise InputError(what, where=str(path), hint="save it again") from error


def _require_room(path: Path, file: BinaryIO) -> None:
    """Raises InputError where chunks declare more than there is room for: by their records, or by what is packed in
    them. Nothing is unpacked."""
    stream = library("mcap.stream_reader", "mcap", path)
    whole = 0
    for record in stream.StreamReader(file, emit_chunks=True).records:
        if type(record).__name__ == "Chunk":
            packed = record.compression == "zstd"
            inner = library("zstandard", "mcap", path).frame_content_size(record.data) if packed else 0
            whole += max(record.uncompressed_size, inner)
            require_room(path, "it", whole)
    file.seek(0)


def _messages(reader: Any, ros2: Any, unknown: set[str]) -> Iterator[Message]:
    """Decoded messages in the order of their logging. unknown : gathers encodings that cannot be read."""
    decoders: dict[int, Decode | None] = {}
    for schema, channel, message in reader.iter_messages():
        if channel.id not in decoders:
            plain = json.loads if channel.message_encoding == "json" else None
            decoders[channel.id] = plain or ros2.decoder_for(channel.message_encoding, schema)
        decode = decoders[channel.id]
        if decode is None:
            unknown.add(channel.message_encoding or "?")
        else:
            yield Message(channel.topic, message.log_time, decode(message.data))
