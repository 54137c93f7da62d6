"""A ROS 1 .bag or a ROS 2 bag folder, whose messages can be fetched in any order; the only user of `rosbags`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from razer.errors import BadInput, UnusableFrame

NANOSECONDS_PER_S = 1e9


@dataclass(frozen=True, slots=True)
class Entry:
    """Where one message of a topic is: its time in the bag, and how many before it share that time; stamp is the
    time in its header, seconds."""

    time_ns: int
    ordinal: int
    stamp: float


@dataclass(frozen=True, slots=True)
class Bag:
    """A bag on disk; it is opened once in each process that reads from it."""

    path: Path

    @property
    def topics(self) -> dict[str, str]:
        """Message type, such as sensor_msgs/msg/Image, of each topic."""
        return {connection.topic: connection.msgtype for connection in _opened(self.path).connections}

    def messages(self, topic: str) -> Iterator[tuple[int, Any]]:
        """(time in the bag in nanoseconds, message) in order of time, to the end or to where the bag is damaged."""
        return ((time, message) for _, time, message in self._read((topic,)) if message is not None)

    def index(self, *topics: str) -> dict[str, tuple[Entry, ...]]:
        """All messages of each topic; they must have headers. Reads through the bag once."""
        times: dict[str, list[tuple[int, int, float]]] = {topic: [] for topic in topics}
        counts: Counter[tuple[str, int]] = Counter()
        for topic, time, message in self._read(topics):
            if message is not None:
                times[topic].append((time, counts[topic, time], _seconds(message.header.stamp)))
            counts[topic, time] += 1
        return {topic: _entries(messages) for topic, messages in times.items()}

    def message(self, topic: str, entry: Entry) -> Any:
        """One message; raises UnusableFrame where the bag is damaged there."""
        for i, (_, _, message) in enumerate(self._read((topic,), entry.time_ns, entry.time_ns + 1)):
            if message is not None and i == entry.ordinal:
                return message
        raise UnusableFrame(f"{topic}: the message at {entry.stamp:.6f} cannot be read")

    def _read(
        self, topics: tuple[str, ...], start: int | None = None, stop: int | None = None
    ) -> Iterator[tuple[str, int, Any]]:
        """(topic, time, message), None for a message that cannot be decoded; ends where the bag itself cannot be read
        further."""
        reader = _opened(self.path)
        connections = [connection for connection in reader.connections if connection.topic in topics]
        messages = reader.messages(connections, start=start, stop=stop)
        while True:
            try:
                connection, time, data = next(messages)
            except StopIteration:
                return
            except Exception:  # each layer below (sqlite, mcap, lz4, bz2) has its own errors for damaged data
                return
            try:
                message = reader.deserialize(data, connection.msgtype)
            except Exception:  # as above
                message = None
            yield connection.topic, time, message


@lru_cache(maxsize=2)
def _opened(path: Path) -> Any:
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise BadInput(f"{path} is a ROS bag, which needs the package rosbags: pip install 'razer[ros]'") from None
    try:
        reader = AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.open()
    except (AnyReaderError, Exception) as error:  # each layer below has its own errors for damaged data
        raise BadInput(f"{path} cannot be opened as a ROS bag ({error}): record or copy it again") from None
    return reader


def _entries(messages: list[tuple[int, int, float]]) -> tuple[Entry, ...]:
    """With the time in the bag as stamp where no header has one."""
    unset = not any(stamp for _, _, stamp in messages)
    return tuple(Entry(time, i, time / NANOSECONDS_PER_S if unset else stamp) for time, i, stamp in messages)


def _seconds(stamp: Any) -> float:
    return float(stamp.sec + stamp.nanosec / NANOSECONDS_PER_S)
