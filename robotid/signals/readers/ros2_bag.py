"""ROS 2 bags in their SQLite form, by rosbags. Columns are named as messages.py says."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from robotid.errors import InputError
from robotid.signals.readers.extra import library
from robotid.signals.readers.messages import Message, from_messages
from robotid.signals.readers.table import Table

SUFFIXES = (".db3",)


def read(path: Path) -> Table:
    """Every number of every topic. A bag without definitions of its messages is read by ROS's own.

    Raises InputError for a damaged file, for a message that ROS does not define, and where rosbags is not installed.
    """
    highlevel, typesys = library("rosbags.highlevel", "rosbag", path), library("rosbags.typesys", "rosbag", path)
    known = typesys.get_typestore(typesys.Stores.LATEST)
    try:
        with highlevel.AnyReader([path], default_typestore=known) as reader:
            return from_messages(str(path), _messages(reader))
    except InputError:
        raise
    except Exception as error:  # a damaged file makes the parser fail in ways that nobody has listed
        what = "this is not a readable ROS 2 bag: foreign, damaged, or of messages that it does not define"
        raise InputError(what, where=str(path), hint="convert it by `ros2 bag convert` to MCAP") from error


def _messages(reader: Any) -> Iterator[Message]:
    for connection, time, raw in reader.messages():
        yield Message(connection.topic, time, reader.deserialize(raw, connection.msgtype))
