"""Reader of ROS bags with RGB-D images: a .bag of ROS 1, or a folder of ROS 2 with metadata.yaml.

Topics are chosen by the type and the name of their messages; a file topics.json in the folder, or NAME.topics.json
beside NAME.bag, with {"color": topic, "depth": topic} chooses others. Needs the package rosbags.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from data_tools.readers.ros.bag_file import Bag, Entry
from data_tools.readers.ros.images import color_of, depth_of, is_depth
from data_tools.readers.ros.transforms import camera_poses, fixed_between, read_links
from data_tools.readers.tum import MAX_DIFFERENCE_S, associate
from data_tools.recordings.camera import Camera, Declared
from data_tools.recordings.recorded_sequence import ImageSource, RecordedSequence, recorded_sequence
from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.errors import BadInput
from razer.files import MALFORMED, read_json

_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
_ALIGNED = ("aligned", "registered", "to_color", "to_rgb")
_NO_CAMERA = ("infra", "confidence", "mask", "label", "segment", "debug", "fisheye")


@dataclass(frozen=True, slots=True)
class BagImages(ImageSource):
    """Pairs of colour and depth messages."""

    bag: Bag
    color_topic: str
    depth_topic: str
    pairs: tuple[tuple[Entry, Entry], ...]

    def __len__(self) -> int:
        return len(self.pairs)

    def stamp(self, index: int) -> float:
        """The time of depth in seconds."""
        return self.pairs[index][1].stamp

    def color(self, index: int) -> Uint8Array:
        """(H, W, 3) in RGB order; raises UnusableFrame."""
        return color_of(self.bag.message(self.color_topic, self.pairs[index][0]), self.color_topic)

    def depth(self, index: int) -> Float32Array:
        """(h, w) in metres, 0 = no reading; raises UnusableFrame."""
        return depth_of(self.bag.message(self.depth_topic, self.pairs[index][1]), self.depth_topic)


def is_ros_bag(path: Path) -> bool:
    """Whether this is a .bag, or a folder with metadata.yaml and a .db3 or .mcap."""
    if path.is_file():
        return path.suffix == ".bag"
    return (path / "metadata.yaml").is_file() and any([*path.glob("*.db3*"), *path.glob("*.mcap*")])


def read_ros_bag(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A bag with colour and depth images; poses come from its transforms, odometry or poses. Reads through the bag
    when it is opened, to know where each image is; raises BadInput, also where rosbags is not installed."""
    bag = Bag(folder)
    color, depth = _image_topics(bag)
    entries = bag.index(color, depth)
    colors, depths = entries[color], entries[depth]
    matches = associate(_stamps(colors), _stamps(depths), MAX_DIFFERENCE_S)
    if not matches:
        raise BadInput(f"{folder}: no image of {color} is within {MAX_DIFFERENCE_S} s of one of {depth}")
    pairs = tuple((colors[c], depths[d]) for c, d in matches)
    source = BagImages(bag, color, depth, pairs)
    links = read_links(bag)
    color_frame, depth_frame = (
        bag.message(topic, entry).header.frame_id.lstrip("/")
        for topic, entry in zip((color, depth), pairs[0], strict=True)
    )
    recorded = declared if declared.depth_camera else _cameras(bag, color, depth, color_frame != depth_frame)
    if color_frame != depth_frame:
        recorded = replace(recorded, color_from_depth=fixed_between(links, color_frame, depth_frame))
    stamps = tuple(entry.stamp for _, entry in pairs)
    poses = camera_poses(bag, links, depth_frame, stamps) if use_poses else None
    return recorded_sequence(folder, source, declared.or_else(recorded), poses, recorded_stamps=True)


def _image_topics(bag: Bag) -> tuple[str, str]:
    first = {
        topic: next((message for _, message in bag.messages(topic)), None)
        for topic, kind in bag.topics.items()
        if kind in _IMAGES
    }
    depths = [topic for topic, message in first.items() if message is not None and is_depth(message)]
    colors = [topic for topic, message in first.items() if message is not None and topic not in depths]
    chosen = _chosen(bag.path)
    color = chosen.get("color") or max(colors, key=_color_likeness, default=None)
    depth = chosen.get("depth") or max(depths, key=_depth_likeness, default=None)
    for what, topic in (("colour", color), ("depth", depth)):
        if topic is None or topic not in first:
            has = ", ".join(f"{name} ({kind.rpartition('/')[2]})" for name, kind in sorted(bag.topics.items()))
            missing = f"{what} images" if topic is None else f"topic {topic}"
            raise BadInput(f"{bag.path} has no {missing}; its topics are: {has or 'none'}")
    assert color is not None
    assert depth is not None
    return color, depth


def _chosen(path: Path) -> dict[str, str]:
    file = path / "topics.json" if path.is_dir() else path.with_suffix(".topics.json")
    if not file.is_file():
        return {}
    try:
        return {str(what): str(topic) for what, topic in read_json(file).items()}
    except MALFORMED:
        raise BadInput(f'{file} must read {{"color": "/a/topic", "depth": "/another"}}') from None


def _color_likeness(topic: str) -> tuple[bool, bool, bool, str]:
    odd = any(word in topic for word in (*_NO_CAMERA, "depth"))
    return not odd, "color" in topic or "rgb" in topic, "compressed" not in topic, topic


def _depth_likeness(topic: str) -> tuple[bool, bool, bool, bool, str]:
    odd = any(word in topic for word in _NO_CAMERA)
    return not odd, any(w in topic for w in _ALIGNED), "depth" in topic, "compressed" not in topic, topic


def _stamps(entries: tuple[Entry, ...]) -> Float64Array:
    return np.array([entry.stamp for entry in entries], dtype=np.float64)


def _cameras(bag: Bag, color: str, depth: str, apart: bool) -> Declared:
    """The cameras in the bag; colour's only where it is another camera or size than that of depth."""
    infos = _camera_infos(bag)
    color_info, depth_info = infos.get(_info_topic(color)), infos.get(_info_topic(depth))
    if depth_info is None and len(infos) == 1:
        depth_info = next(iter(infos.values()))
    if depth_info is None and not apart:
        depth_info = color_info
    if depth_info is None:
        return Declared()
    depth_camera = _camera(depth_info, "rect" in depth)
    if color_info is None or not (apart or (color_info.width, color_info.height) != depth_camera.size):
        return Declared(depth_camera)
    return Declared(depth_camera, _camera(color_info, "rect" in color))


def _camera_infos(bag: Bag) -> dict[str, Any]:
    """Topic -> its first CameraInfo message."""
    topics = [topic for topic, kind in bag.topics.items() if kind == _CAMERA_INFO]
    first = {topic: next((message for _, message in bag.messages(topic)), None) for topic in topics}
    return {topic: info for topic, info in first.items() if info is not None}


def _info_topic(topic: str) -> str:
    """camera_info beside an image topic: /camera/depth/image_raw/compressedDepth has /camera/depth/camera_info."""
    for ending in ("/compressedDepth", "/compressed"):
        topic = topic.removesuffix(ending)
    # librealsense writes .../image/data and .../info/camera_info.
    if topic.endswith("/image/data"):
        return topic.removesuffix("/image/data") + "/info/camera_info"
    return topic.rpartition("/")[0] + "/camera_info"


def _camera(info: Any, rectified: bool) -> Camera:
    """K and the distortion of a camera_info, or the projection of images that are rectified already."""
    k, d, p = (getattr(info, name if hasattr(info, name) else name.upper()) for name in "kdp")
    size = (int(info.width), int(info.height))
    if rectified and p[0]:
        return Camera(p[0], p[5], p[2], p[6], size=size)
    numbers = [float(x) for x in d]
    if any(numbers[5:]) or (any(numbers) and info.distortion_model in ("equidistant", "fisheye")):
        raise BadInput(
            f"its camera has the distortion model {info.distortion_model} with {len(numbers)} numbers, which is not "
            "known here: give --intrinsics fx,fy,cx,cy,k1,k2,p1,p2,k3"
        )
    numbers = (numbers + [0.0] * 5)[:5]
    return Camera(float(k[0]), float(k[4]), float(k[2]), float(k[5]), tuple(numbers) if any(numbers) else (), size)
