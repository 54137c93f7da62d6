"""Small ROS bags of both generations, written by rosbags' own writers."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

KINDS = ("ros1", "sqlite3", "mcap")


class Messages:
    """Makes the messages of one generation of ROS; stamps in seconds."""

    def __init__(self, kind: str) -> None:
        self.is1 = kind == "ros1"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.is1 else Stores.ROS2_HUMBLE)
        if self.is1:
            text = "geometry_msgs/TransformStamped[] transforms"
            self.store.register(get_types_from_msg(text, "tf2_msgs/msg/TFMessage"))

    def make(self, name: str, *values: Any) -> Any:
        return self.store.types[name](*values)

    def header(self, stamp: float, frame: str) -> Any:
        nanoseconds = round(stamp * 1e9)
        time = self.make("builtin_interfaces/msg/Time", nanoseconds // 10**9, nanoseconds % 10**9)
        return self.make("std_msgs/msg/Header", *([0] if self.is1 else []), time, frame)

    def image(self, stamp: float, frame: str, array: np.ndarray, encoding: str, padding: int = 0) -> Any:
        rows = np.ascontiguousarray(array).view(np.uint8).reshape(array.shape[0], -1)
        rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=77)
        big = int(array.dtype.byteorder == ">")
        size = (array.shape[0], array.shape[1])
        return self.make(
            "sensor_msgs/msg/Image", self.header(stamp, frame), *size, encoding, big, rows.shape[1], rows.ravel()
        )

    def compressed(self, stamp: float, frame: str, array: np.ndarray, form: str, head: bytes = b"") -> Any:
        array = array[..., ::-1] if array.ndim == 3 else array
        data = np.frombuffer(head + cv2.imencode(".png", array)[1].tobytes(), np.uint8)
        return self.make("sensor_msgs/msg/CompressedImage", self.header(stamp, frame), form, data)

    def info(self, frame: str, size: tuple[int, int], k: tuple[float, ...], d: Iterable[float] = (0.0,) * 5) -> Any:
        matrix = np.array([k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1.0])
        projection = np.array([k[0], 0, k[2], 0, 0, k[1], k[3], 0, 0, 0, 1.0, 0])
        numbers = np.array(list(d), dtype=np.float64)
        model = "rational_polynomial" if numbers.size == 8 else "plumb_bob"
        region = self.make("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
        head = (self.header(0, frame), size[1], size[0], model)
        return self.make(
            "sensor_msgs/msg/CameraInfo", *head, numbers, matrix, np.eye(3).ravel(), projection, 0, 0, region
        )

    def transform(self, stamp: float, parent: str, child: str, place: Iterable[float], turn: Iterable[float]) -> Any:
        transform = self.make(
            "geometry_msgs/msg/Transform",
            self.make("geometry_msgs/msg/Vector3", *place),
            self.make("geometry_msgs/msg/Quaternion", *turn),
        )
        stamped = self.make("geometry_msgs/msg/TransformStamped", self.header(stamp, parent), child, transform)
        return self.make("tf2_msgs/msg/TFMessage", [stamped])

    def pose(self, stamp: float, frame: str, place: Iterable[float], turn: Iterable[float]) -> Any:
        pose = self.make(
            "geometry_msgs/msg/Pose",
            self.make("geometry_msgs/msg/Point", *place),
            self.make("geometry_msgs/msg/Quaternion", *turn),
        )
        return self.make("geometry_msgs/msg/PoseStamped", self.header(stamp, frame), pose)


def compressed_depth_head(a: float, b: float) -> bytes:
    return struct.pack("<iff", 0, a, b)


def write_bag(path: Path, kind: str, messages: list[tuple[str, float, Any]]) -> Path:
    """(topic, time in the bag in seconds, message), in any order; returns the .bag or the folder."""
    store = Messages(kind).store
    if kind == "ros1":
        path = path.with_suffix(".bag")
        writer: Any = Writer1(path)
    else:
        plugin = StoragePlugin.SQLITE3 if kind == "sqlite3" else StoragePlugin.MCAP
        writer = Writer2(path, version=8, storage_plugin=plugin)
    serialize = store.serialize_ros1 if kind == "ros1" else store.serialize_cdr
    with writer:
        connections: dict[str, Any] = {}
        for topic, time, message in sorted(messages, key=lambda item: item[1]):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=store)
            writer.write(connections[topic], round(time * 1e9), serialize(message, message.__msgtype__))
    return path
