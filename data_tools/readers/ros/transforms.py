"""Camera poses from the transform tree, odometry or poses of a ROS bag."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from data_tools.readers.ros.bag_file import Bag
from data_tools.recordings.trajectories import PoseSource, PoseWithNotes, Trajectory, checked_pose
from razer.arrays import Float64Array
from razer.geometry import inverse

_TF = "tf2_msgs/msg/TFMessage"
_OLD_TF = "tf/msg/tfMessage"
_ODOMETRY = "nav_msgs/msg/Odometry"
_BODY_POSES = (_ODOMETRY, "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped",
               "geometry_msgs/msg/TransformStamped")  # fmt: skip
_STILL = 1e-6  # metres and quaternion parts within which a transform counts as constant


@dataclass(frozen=True, slots=True)
class Link:
    """parent_from_child over time; constant where it never changes."""

    parent: str
    motion: Trajectory
    constant: bool

    def at(self, stamp: float) -> Float64Array:
        """The (4, 4) transform at a time in seconds; raises UnusableFrame where it is not known."""
        return (self.motion.nearest(self.motion.stamps[0]) if self.constant else self.motion.interpolated(stamp))[0]


@dataclass(frozen=True, slots=True)
class ChainPoses:
    """The pose of a camera through a chain of transforms, from the camera up to the world."""

    links: tuple[Link, ...]
    stamps: tuple[float, ...]

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame."""
        pose = np.eye(4)
        for link in self.links:
            pose = link.at(self.stamps[index]) @ pose
        return checked_pose(pose, "the chain of transforms")


def read_links(bag: Bag) -> dict[str, Link]:
    """The link to its parent of every frame in the transforms, or else in odometry."""
    links: dict[str, Link] = {}
    for kinds in ((_TF, _OLD_TF), (_ODOMETRY,)):
        rows: dict[str, dict[str, list[tuple[float, ...]]]] = {}
        for topic in (topic for topic, kind in bag.topics.items() if kind in kinds):
            for time, message in bag.messages(topic):
                for child, parent, row in _transforms(message, time):
                    rows.setdefault(child, {}).setdefault(parent, []).append(row)
        for child, parents in rows.items():
            parent, poses = max(parents.items(), key=lambda item: len(item[1]))
            links.setdefault(child, _link(parent, poses))
    return links


def _transforms(message: Any, time_ns: int) -> Iterable[tuple[str, str, tuple[float, ...]]]:
    """(child, parent, row) of each transform in a message."""
    if hasattr(message, "transforms"):
        transforms = [(each.child_frame_id, each.header, each.transform) for each in message.transforms]
    else:
        transforms = [(message.child_frame_id, message.header, message.pose.pose)]
    named = [(_name(child), _name(header.frame_id), _row(header, pose, time_ns)) for child, header, pose in transforms]
    return [(child, parent, row) for child, parent, row in named if child and child != parent]


def camera_poses(bag: Bag, links: dict[str, Link], camera: str, stamps: tuple[float, ...]) -> PoseSource | None:
    """Poses of a camera in the root of its transforms.

    Where nothing moves there, the first topic with poses or odometry is taken for the camera's own; None where there
    is neither.

    Args:
        bag: whose topics are searched.
        links: its transforms, as read_links returns them.
        camera: the frame of the camera.
        stamps: of the images, seconds.
    """
    chain = chain_of(links, camera)
    if any(not link.constant for link in chain):
        return ChainPoses(tuple(chain), stamps)
    topics = sorted(topic for topic, kind in bag.topics.items() if kind in _BODY_POSES)
    for topic in sorted(topics, key=lambda topic: "cam" not in topic):
        rows = [_row(message.header, _pose(message), time) for time, message in bag.messages(topic)]
        if len(rows) > 1:
            return ChainPoses((_link("world", rows),), stamps)
    return None


def chain_of(links: dict[str, Link], frame: str) -> list[Link]:
    """The links from a frame up to the root."""
    chain, visited, current = [], set[str](), _name(frame)
    while current in links and current not in visited:
        visited.add(current)
        chain.append(links[current])
        current = links[current].parent
    return chain


def fixed_between(links: dict[str, Link], target: str, source: str) -> Float64Array | None:
    """target_from_source where both hang together by constant transforms, else None."""
    up_from_target, up_from_source = _fixed_ancestors(links, target), _fixed_ancestors(links, source)
    common = next((frame for frame in up_from_source if frame in up_from_target), None)
    return None if common is None else inverse(up_from_target[common]) @ up_from_source[common]


def _fixed_ancestors(links: dict[str, Link], frame: str) -> dict[str, Float64Array]:
    """ancestor_from_frame for each ancestor within reach of constant links, the frame itself first."""
    ancestors, pose = {_name(frame): np.eye(4)}, np.eye(4)
    for link in chain_of(links, frame):
        if not link.constant:
            break
        pose = link.at(0.0) @ pose
        ancestors[link.parent] = pose
    return ancestors


def _link(parent: str, rows: Iterable[tuple[float, ...]]) -> Link:
    table = np.array(sorted(rows), dtype=np.float64)
    table = table[np.isfinite(table[:, 0])]
    constant = bool(len(table)) and bool((np.abs(table[:, 1:] - table[:1, 1:]) <= _STILL).all())
    return Link(parent, Trajectory("transforms", table[:, 0], table[:, 1:4], table[:, 4:]), constant)


def _row(header: Any, pose: Any, time_ns: int) -> tuple[float, ...]:
    stamp = header.stamp.sec + header.stamp.nanosec / 1e9
    place = pose.translation if hasattr(pose, "translation") else pose.position
    turn = pose.rotation if hasattr(pose, "rotation") else pose.orientation
    return (stamp or time_ns / 1e9, place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)


def _pose(message: Any) -> Any:
    if hasattr(message, "transform"):
        return message.transform
    return message.pose.pose if hasattr(message.pose, "pose") else message.pose


def _name(frame: str) -> str:
    """A frame without the leading slash that older ROS puts before it."""
    return frame.lstrip("/")
