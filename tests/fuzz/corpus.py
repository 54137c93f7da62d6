"""The smallest valid file of each kind, made by the project's own writers, and what reads it."""

from __future__ import annotations

import json
import shutil
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import cv2
import numpy as np

from app.evaluation.prediction import read_prediction
from app.query.query_image import embed_query_image
from app.query.queryable_map import open_map
from app.run_folder.mapped_run import read_run
from app.settings.config_file import read_config
from app.settings.run_config import RunConfig
from app.stored_state.checkpoint import Checkpoint, read_checkpoint
from app.stored_state.saved_state import SavedState
from app.stored_state.state_codec import KnownObjects
from app.stored_state.state_files import StateWriter, load_state
from data_tools.predictions.submission_writer import write_submission
from data_tools.readers import record3d_images
from data_tools.readers.ros import bag_file
from data_tools.recordings.camera import declare
from data_tools.recordings.rgbd_calibration import read_rgbd_calibration
from data_tools.registry import open_sequence
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.open_truth import open_truth
from data_tools.truth.truth_folder import write_truth
from data_tools.writers.scannet_truth import write_scannet_truth
from data_tools.writers.table import WRITERS, write_recording
from razer.errors import UnusableFrame
from razer.models import make_embedder
from razer.models.stored_masks import StoredMasks
from razer.panoptic_map import PanopticMap
from razer.saved_map import load_map
from razer.storage.settings_list import list_settings
from razer.storage.toml_text import toml_text
from razer.vocabulary import vocabulary
from tests.fuzz.model_files import MODEL_FILES, write_pictures
from tests.support.edited_maps import CHAIR, TABLE, do, hand_made, saved, session_of
from tests.support.labelled_meshes import furnished_room
from tests.support.pose_files import curved_path, write_colmap, write_kitti, write_transforms, write_tum_lines
from tests.support.recordings import HEIGHT, WIDTH, camera_json, colour, depth, write_folder
from tests.support.ros_recordings import Messages, write_bag

RUN = Path(__file__).resolve().parent.parent / "fixtures" / "run_format_1"
EMBEDDER = make_embedder("appearance", {})


@dataclass(frozen=True)
class Kind:
    """make(folder) writes valid files into a new folder, read(folder) reads them; changed: patterns of paths of
    what is changed."""

    make: Callable[[Path], object]
    read: Callable[[Path], object]
    changed: tuple[str, ...] = field(default=("**/*",))
    is_text: bool = False  # what is read is no file but a text, so that there is none to be named


def read_frames(path: Path) -> None:
    sequence = open_sequence(path)
    for index in range(min(len(sequence), 4)):
        with suppress(UnusableFrame):
            sequence[index]


def _recording(layout: str) -> Kind:
    room = SyntheticRoom(0, 2, 32, 24)
    truth = furnished_room(0.6) if layout in ("scannet", "replica", "scenenn") else None
    return Kind(
        lambda folder: write_recording(room, folder / layout, layout, truth=truth), lambda f: read_frames(f / layout)
    )


def _scenenn(folder: Path) -> None:
    write_recording(SyntheticRoom(0, 1, 32, 24), folder / "scene", "scenenn", truth=furnished_room(0.6))


def _write_ascii_ply(folder: Path) -> None:
    folder.mkdir()
    corners = "\n".join(f"{x} {y} 0 {x + y} 1" for x in range(3) for y in range(3))
    properties = "".join(f"property float {name}\n" for name in "xyz")
    head = f"ply\nformat ascii 1.0\nelement vertex 9\n{properties}property int instance\nproperty int class\n"
    faces = "element face 3\nproperty list uchar int vertex_indices\nend_header\n"
    (folder / "mesh.ply").write_text(f"{head}{faces}{corners}\n3 0 1 3\n3 1 4 3\n4 4 5 8 7\n")
    (folder / "classes.json").write_text('{"1": "chair"}')


def _write_r3d(folder: Path) -> None:
    import liblzfse

    folder.mkdir()
    told = {
        "w": 8,
        "h": 6,
        "dw": 4,
        "dh": 3,
        "fps": 30,
        "K": [10, 0, 0, 0, 10, 0, 3.5, 2.5, 1],
        "poses": [[0, 0, 0, 1] + [0] * 3],
    }
    with zipfile.ZipFile(folder / "a.r3d", "w") as archive:
        archive.writestr("metadata", json.dumps(told))
        archive.writestr("rgbd/0.jpg", cv2.imencode(".jpg", np.full((6, 8, 3), 90, np.uint8))[1].tobytes())
        archive.writestr("rgbd/0.depth", liblzfse.compress(np.ones((3, 4), np.float32).tobytes()))
        archive.writestr("rgbd/0.conf", liblzfse.compress(np.full((3, 4), 2, np.uint8).tobytes()))


def _read_r3d(folder: Path) -> None:
    record3d_images.opened.cache_clear()
    read_frames(folder / "a.r3d")


def _write_bag(kind: str) -> Callable[[Path], object]:
    def write(folder: Path) -> None:
        make, size = Messages(kind), (WIDTH, HEIGHT)
        messages = [
            (f"/{camera}/camera_info", 100, make.info("c", size, (9, 9, 3, 2))) for camera in ("color", "depth")
        ]
        for stamp in (100, 101):
            messages.append(("/color/image", stamp, make.image(stamp, "c", colour(), "rgb8")))
            messages.append(("/depth/image", stamp, make.image(stamp, "c", depth(), "16UC1")))
            messages.append(("/pose", stamp, make.pose(stamp, "world", (stamp, 0, 0), (0, 0, 0, 1))))
        folder.mkdir()
        write_bag(folder / "bag", kind, messages)

    return write


def _read_bag(folder: Path) -> None:
    bag_file._opened.cache_clear()
    read_frames(folder)


def _write_edited(folder: Path) -> None:
    saved(folder)
    session = session_of(folder)
    do(session, "rename", instance=CHAIR, name="stool")
    do(session, "relabel", instance=TABLE, class_name="desk")
    do(session, "delete", instance=CHAIR)


def _write_submission(folder: Path) -> None:
    masks = {1: np.array([0, 1]), 2: np.array([2, 3])}
    write_submission(folder, "scene", masks, {1: 3, 2: 4}, {1: 0.5, 2: 0.25}, 6)


def _write_labels(folder: Path) -> None:
    folder.mkdir()
    (folder / "a.txt").write_text("3001\n4002\n0\n0\n3001\n0\n")
    np.save(folder / "b.npy", np.array([1, 1, 2, 2, 0, 0]))
    (folder / "c.txt").write_text("3\n3\n4\n4\n0\n0\n")
    (folder / "c_instances.txt").write_text("1\n1\n2\n2\n0\n0\n")
    (folder / "c_confidences.txt").write_text("1 3 0.5\n2 4 0.25\n")


def _read_labels(folder: Path) -> None:
    for name in ("a.txt", "b.npy", "c.txt"):
        read_prediction(folder / name, {3: "chair", 4: "table"}, 6)


def _write_state(folder: Path) -> None:
    folder.mkdir()
    shared = np.arange(6.0)
    state = {"a": [1, 2.5, None, "x"], "b": (shared, shared), "c": {1: {2, 3}}, "d": b"bytes", "e": np.float32(1)}
    saved_state = StateWriter(folder, "map", KnownObjects({}, {}, {})).save(state)
    Checkpoint(1, 2, saved_state, SavedState("poses", 0, ()), "ab12").write(folder)


def _read_state(folder: Path) -> None:
    checkpoint = read_checkpoint(folder)
    if checkpoint is not None:
        load_state(folder, checkpoint.map, KnownObjects({}, {}, {}))


def _write_texts(folder: Path) -> None:
    folder.mkdir()
    (folder / "set.txt").write_text('input.depth_scale=1000\nsegmenter.name="geometric"\nvoxels.voxel_size_m = 0.02\n')
    (folder / "config.toml").write_text(toml_text(list_settings(RunConfig())))


def _read_texts(folder: Path) -> None:
    texts = (folder / "set.txt").read_bytes().decode("utf-8", "surrogateescape").split("\n")
    read_config(folder / "config.toml", [text for text in texts if text], {})


def _write_tables(folder: Path) -> None:
    folder.mkdir()
    (folder / "list.csv").write_text("id,name,nyu40,group,stuff\n1,chair,5,head,0\n2,wall,1,,1\n")
    (folder / "names.txt").write_text("chair\ntable\n")
    (folder / "camera.json").write_text(json.dumps({"width": 8, "height": 6, "fx": 9, "fy": 9, "cx": 3.5, "cy": 2.5}))
    np.savetxt(folder / "matrix.txt", np.eye(4))
    eye = {
        "color": {"width": 8, "height": 6, "fx": 9, "fy": 9, "cx": 3, "cy": 2},
        "color_from_depth": np.eye(4).tolist(),
    }
    (folder / "calibration.json").write_text(json.dumps(eye))


def _read_tables(folder: Path) -> None:
    vocabulary.cache_clear()
    vocabulary(str(folder / "list.csv"))
    vocabulary(str(folder / "names.txt"))
    declare(str(folder / "camera.json"), None, folder / "matrix.txt")
    read_rgbd_calibration(folder / "calibration.json")


def _read_pictures(folder: Path) -> None:
    for name in ("a.png", "b.jpg"):
        embed_query_image(EMBEDDER, "appearance", folder / name, None)


def _write_masks(folder: Path) -> None:
    folder.mkdir()
    (folder / "000000.png").write_bytes(cv2.imencode(".png", np.eye(24, 32, dtype=np.uint8))[1].tobytes())
    masks = np.zeros((2, 24, 32), np.bool_)
    np.savez_compressed(
        folder / "000001.npz", masks=masks, scores=np.ones(2), names=np.array(["a", "b"]), stuff=np.zeros(2)
    )


def _read_masks(folder: Path) -> None:
    room = SyntheticRoom(0, 2, 32, 24)
    segmenter = StoredMasks(str(folder))
    for index in range(2):
        with suppress(UnusableFrame):
            segmenter.segment(room[index])


def _query(folder: Path) -> None:
    """What razer query asks of a folder with a text of its own."""
    text = (folder / "query.txt").read_bytes().decode("utf-8", "surrogateescape")
    _map_to_ask().query(text)


@cache
def _map_to_ask() -> PanopticMap:
    return hand_made()


def _write_query(folder: Path) -> None:
    folder.mkdir()
    (folder / "query.txt").write_text("a chair; table | lamp")


POSES = curved_path(2)
POSE_FILES: dict[str, Callable[[Path], object]] = {
    "tum poses": lambda path: write_tum_lines(path, [0.0, 1 / 30], POSES),
    "kitti poses": lambda path: write_kitti(path, POSES),
    "colmap poses": lambda path: write_colmap(path, ["000000.png", "000001.png"], POSES),
    "transforms": lambda path: write_transforms(path, ["000000.png", "000001.png"], POSES),
}


def _pose_file(write: Callable[[Path], object]) -> Kind:
    def make(folder: Path) -> None:
        write_folder(folder, 2, camera_json())
        write(folder / "poses.txt")

    def read(folder: Path) -> None:
        sequence = open_sequence(folder, poses_from=folder / "poses.txt")
        for index in range(2):
            with suppress(UnusableFrame):
                sequence[index]

    return Kind(make, read, ("poses.txt",))


KINDS: dict[str, Kind] = {
    **{name: _pose_file(write) for name, write in POSE_FILES.items()},
    **{name: Kind(*of_kind) for name, of_kind in MODEL_FILES.items()},
    **{layout: _recording(layout) for layout in WRITERS},
    "record3d": Kind(_write_r3d, _read_r3d),
    "ros1": Kind(_write_bag("ros1"), lambda f: _read_bag(f / "bag.bag")),
    "ros2": Kind(_write_bag("sqlite3"), lambda f: _read_bag(f / "bag")),
    "truth": Kind(lambda f: write_truth(furnished_room(0.6), f), open_truth),
    "ascii truth": Kind(_write_ascii_ply, open_truth),
    "scenenn truth": Kind(_scenenn, lambda f: open_truth(f / "scene")),
    "scannet truth": Kind(lambda f: (f.mkdir(), write_scannet_truth(furnished_room(0.6), f, "s")), open_truth),
    "run": Kind(lambda f: shutil.copytree(RUN, f), read_run, ("*.json", "*.npz", "*.ply", "*.txt", "*.toml")),
    "opened run": Kind(lambda f: shutil.copytree(RUN, f), lambda f: open_map(f)[0].volume, ("config.toml", "map.npz")),
    "edited map": Kind(_write_edited, load_map),
    "submission": Kind(_write_submission, lambda f: read_prediction(f, {3: "chair", 4: "table"}, 6)),
    "labels": Kind(_write_labels, _read_labels),
    "state": Kind(_write_state, _read_state),
    "settings": Kind(_write_texts, _read_texts, is_text=True),
    "tables": Kind(_write_tables, _read_tables),
    "pictures": Kind(write_pictures, _read_pictures),
    "masks": Kind(_write_masks, _read_masks),
    "query": Kind(_write_query, _query, is_text=True),
}
