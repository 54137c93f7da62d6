"""Annotated instances of ScanNet's frames, in made-up files of the published form, on the grid of depth."""

from __future__ import annotations

import json
import pickle
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pytest

from data_tools.registry import open_sequence
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.label_map import FILE_NAME
from data_tools.writers.scannet import write_scannet
from razer.errors import BadInput, UnusableFrame
from razer.models.oracle.segmenter import OracleSegmenter
from tests.data_tools.readers.test_scannet import COLOR_CAMERA, DEPTH_CAMERA, DEPTH_SIZE, WALL_M, write_wall

SCENE = "scene0000_00"
MOVED = np.array([[1, 0, 0, 0.05], [0, 1, 0, 0.02], [0, 0, 1, -0.03], [0, 0, 0, 1.0]])
OBJECTS = {0: "office chair", 1: "my thing"}  # objectId: in the images they are 1 and 2


def object_at(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Objects in stripes over the wall, metres: nobody, 1, 2."""
    return ((np.floor(x / 0.3) + np.floor(y / 0.4)) % 3).astype(np.uint8)


def seen_by_color(extrinsic: np.ndarray, scale: int = 1) -> np.ndarray:
    """The objects in the colour image, or one so many times as large."""
    camera = COLOR_CAMERA.resized(COLOR_CAMERA.width * scale, COLOR_CAMERA.height * scale)
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    z = WALL_M + extrinsic[2, 3]
    x, y = (u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z
    return object_at(x - extrinsic[0, 3], y - extrinsic[1, 3])


def annotate(folder: Path, ids: np.ndarray, kind: str = "instance-filt", names: tuple[str, ...] = ("0", "1")) -> None:
    (folder / kind).mkdir()
    for name in names:
        cv2.imwrite(str(folder / kind / f"{name}.png"), ids)
    groups = [{"id": n, "objectId": n, "segments": [n], "label": label} for n, label in OBJECTS.items()]
    (folder / f"{folder.name}.aggregation.json").write_text(json.dumps({"segGroups": groups}))


def assert_ids_lie_on_depth(ids: np.ndarray) -> None:
    """Every pixel has the object of the point at its depth, except within two pixels of another object."""
    v, u = np.mgrid[4 : DEPTH_SIZE[1] - 4, 4 : DEPTH_SIZE[0] - 4]
    fx, fy, cx, cy = DEPTH_CAMERA.fx, DEPTH_CAMERA.fy, DEPTH_CAMERA.cx, DEPTH_CAMERA.cy
    offsets = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    nearby = np.stack([object_at((u + i - cx) / fx * WALL_M, (v + j - cy) / fy * WALL_M) for i, j in offsets])
    inner = (nearby == nearby[4]).all(axis=0)
    assert inner.mean() > 0.7
    np.testing.assert_array_equal(ids[4:-4, 4:-4][inner], nearby[4][inner])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("scale", [1, 2])
def test_ids_of_the_colour_image_lie_where_depth_sees_the_objects(tmp_path: Path, dtype: type, scale: int) -> None:
    folder = write_wall(tmp_path / SCENE, MOVED)
    annotate(folder, seen_by_color(MOVED, scale).astype(dtype))
    frame = pickle.loads(pickle.dumps(open_sequence(folder)))[1]
    assert frame.instance_ids is not None
    assert_ids_lie_on_depth(frame.instance_ids)
    assert frame.instance_classes == {1: "office chair", 2: "my thing"}
    masks = OracleSegmenter().segment(frame)
    assert masks.class_names == ("office chair", "my thing")
    # The test can fail: without the motion between the cameras the objects lie elsewhere.
    annotate_again = seen_by_color(np.eye(4), scale).astype(dtype)
    cv2.imwrite(str(folder / "instance-filt" / "1.png"), annotate_again)
    with pytest.raises(AssertionError):
        assert_ids_lie_on_depth(open_sequence(folder)[1].instance_ids)


def test_filtered_images_go_before_plain_ones_and_a_zip_is_read_as_it_comes(tmp_path: Path) -> None:
    folder = write_wall(tmp_path / SCENE)
    annotate(folder, np.zeros((121, 162), np.uint8), kind="instance")
    assert not open_sequence(folder)[0].instance_ids.any()
    with zipfile.ZipFile(folder / f"{SCENE}_2d-instance-filt.zip", "w") as archive:
        for name in ("0", "1"):
            content = cv2.imencode(".png", seen_by_color(np.eye(4)))[1].tobytes()
            archive.writestr(f"instance-filt/{name}.png", content)
    assert_ids_lie_on_depth(pickle.loads(pickle.dumps(open_sequence(folder)))[1].instance_ids)


def test_names_are_those_of_the_label_map_where_it_has_them(tmp_path: Path) -> None:
    folder = write_wall(tmp_path / "scans" / SCENE)
    annotate(folder, seen_by_color(np.eye(4)))
    (tmp_path / FILE_NAME).write_text("id\traw_category\tcategory\tnyu40id\n2\toffice chair\tchair\t5\n")
    assert open_sequence(folder)[0].instance_classes == {1: "chair", 2: "my thing"}


def test_a_frame_without_annotation_has_no_ids_and_a_damaged_one_is_named(tmp_path: Path) -> None:
    folder = write_wall(tmp_path / SCENE)
    annotate(folder, seen_by_color(np.eye(4)), names=("1",))
    sequence = open_sequence(folder)
    assert sequence[0].instance_ids is None
    assert sequence[1].instance_ids is not None
    for content, message in ((b"", "is empty"), (cv2.imencode(".png", np.zeros((9, 9, 3)))[1].tobytes(), "grey image")):
        (folder / "instance-filt" / "1.png").write_bytes(content)
        with pytest.raises(UnusableFrame, match=rf"instance-filt/1\.png .*{message}"):
            open_sequence(folder)[1]
    cv2.imwrite(str(folder / "instance-filt" / "1.png"), np.zeros((60, 60), np.uint8))
    with pytest.raises(UnusableFrame, match=r"instance-filt/1\.png is 60x60, but the colour image is 162x121"):
        open_sequence(folder)[1]
    (folder / f"{SCENE}.aggregation.json").write_text("{}")
    with pytest.raises(BadInput, match=r"aggregation\.json"):
        open_sequence(folder)


def test_a_sens_file_with_its_annotation_beside_it(tmp_path: Path) -> None:
    room = SyntheticRoom(0, 2, 64, 48)
    write_scannet(room, tmp_path / SCENE, sens=True)
    expected = room[1].instance_ids
    (tmp_path / SCENE / "instance-filt").mkdir()
    cv2.imwrite(str(tmp_path / SCENE / "instance-filt" / "1.png"), expected.astype(np.uint8))
    frame = open_sequence(tmp_path / SCENE)[1]
    np.testing.assert_array_equal(frame.instance_ids, expected)
