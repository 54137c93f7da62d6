"""The recording of a scripted run, read back: which streams it holds, how often, and known values in them."""

from __future__ import annotations

import inspect
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import rerun as rr

from app.timeline import entities as paths
from app.timeline.config import TimelineConfig
from app.timeline.null_timeline import NullTimeline
from app.timeline.rerun_timeline import Timeline
from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.config import VoxelSettings
from razer.frame import Frame, Intrinsics
from razer.mesh.labelled_mesh import LabelledMesh
from razer.tracking.step_result import Candidate, Decision, StepResult
from razer.volume.mesh_extraction import extract_mesh
from razer.volume.voxel_map import VoxelMap
from tests.support.timeline_rows import chunks_of

CAMERA = Intrinsics(64, 48, 50.0, 50.0, 31.5, 23.5)
WALL_M = 1.25
BOX = OrientedBox(np.array([0.5, -0.25, 2.0]), np.eye(3), np.array([0.2, 0.4, 0.6]))


def frame(index: int) -> Frame:
    """A red wall, parallel to the image."""
    rgb = np.full((48, 64, 3), (200, 30, 30), np.uint8)
    return Frame(index, index / 30, rgb, np.full((48, 64), WALL_M, np.float32), CAMERA, np.eye(4))


@dataclass
class ScriptedMapper:
    """A real volume, and tracks that the test made up."""

    voxels: VoxelMap = field(default_factory=lambda: VoxelMap(VoxelSettings(surface_weight=1.0)))
    tracks: list = field(default_factory=list)

    def step(self, index: int) -> StepResult:
        ids = np.zeros((48, 64), np.int32)
        ids[:24] = 7
        decisions = (
            Decision(0, (Candidate(7, 0.1, 0.2, 0.14), Candidate(3, 0.9, 0.8, 0.86)), 0.45, "matched", 7),
            Decision(1, (Candidate(3, 0.9, 0.8, 0.86),), 0.45, "born", 8 + index),
        )
        changed = self.voxels.integrate(frame(index))
        return StepResult(index, ids, (), decisions, ((5, 7),), (2,), changed)


def track(track_id: int, confirmed: bool) -> SimpleNamespace:
    known = {"class_name": "chair", "class_votes": (ClassVote("chair", 0, 4, 2.0, 0.9),)} if track_id == 7 else {}
    unknown = {"class_name": None, "class_votes": ()}
    counts = {"n_voxels": 1, "score": 0.8, "first_frame": 0, "last_frame": 3, "observations": 4}
    return SimpleNamespace(id=track_id, box=BOX, confirmed=confirmed, is_stuff=False, **counts, **(unknown | known))


def record(path: Path, config: TimelineConfig, n_frames: int = 4) -> ScriptedMapper:
    mapper = ScriptedMapper(tracks=[track(7, True), track(9, False)])
    timeline = Timeline(path, CAMERA, config)
    for index in range(n_frames):
        timeline.show(frame(index), mapper.step(index), mapper, {"lift": 2.5, "vote": float(index)})
    timeline.skipped(n_frames, "the depth image is empty")
    timeline.finish(SimpleNamespace(objects=mapper.tracks[:1], mesh=extract_mesh(mapper.voxels), up=None))
    timeline.close()
    return mapper


@pytest.fixture(scope="module")
def recording_path(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("timeline") / "timeline.rrd"
    config = TimelineConfig(image_every=2, ids_every=1, depth_every=3, surface_every=1, surface_growth=1.1)
    record(path, config)
    return path


@pytest.fixture(scope="module")
def recording(recording_path) -> dict[str, list[dict]]:
    return chunks_of(recording_path)


@pytest.mark.parametrize(
    ("entity", "frames"),
    [
        (paths.COLOR, [0, 2, 5]),  # the last one again, where a viewer reads it first
        (paths.DEPTH, [0, 3]),
        (paths.INSTANCE_IMAGE, [0, 1, 2, 3, 5]),
        (paths.CAMERA, [0, 1, 2, 3, 5]),
        (paths.DECISIONS, [0, 1, 2, 3]),
        (paths.STAGES, [0, 1, 2, 3, 4]),
        (paths.INSTANCES, [0, 1, 2, 3]),
        (paths.MEMORY, [0, 1, 2, 3, 4]),
        (paths.SUMMARY, [0, 1, 2, 3, 5]),
        (paths.SURFACE, [5]),
        (paths.PATH, [5]),
    ],
)
def test_stream_has_its_frames(recording, entity, frames):
    logged = [row["frame"] for row in recording[entity] if "frame" in row]
    assert logged == frames


def test_the_finished_map_comes_first_and_images_last(recording_path):
    order = [chunk.entity_path.lstrip("/") for chunk in rr.chunk.RrdReader(recording_path).stream().to_chunks()]
    assert order[0] == paths.SURFACE
    first = {entity: order.index(entity) for entity in (paths.BOXES, paths.LABELS, paths.SUMMARY, paths.STAGES)}
    bulk = [n for n, entity in enumerate(order) if entity == paths.DECISIONS or entity.startswith(f"{paths.GROWING}/")]
    assert max(first.values()) < min(bulk)
    assert set(order[min(bulk) :]) & set(first) == set()


def test_parts_are_gone_when_the_recording_is_there(recording_path):
    assert [path.name for path in recording_path.parent.iterdir()] == ["timeline.rrd"]


def test_the_box_of_a_finished_thing_has_its_name_beside_it(recording):
    box = recording[paths.BOXES][-1]
    assert box["frame"] == 5
    assert box["centers"] == [pytest.approx([0.5, -0.25, 2.0])]
    assert box["half_sizes"] == [pytest.approx([0.1, 0.2, 0.3])]
    assert recording[paths.LABELS][-1]["labels"] == ["chair #7"]


def test_no_box_is_shown_of_what_has_no_surface_yet(recording):
    assert [row for row in recording[paths.BOXES] if row.get("frame", 9) < 5 and "centers" in row] == []


def test_an_object_is_one_entity_with_box_points_facts_and_life(recording):
    rows = recording[f"{paths.OBJECTS}/chair_7"]
    merged = {key: value for row in rows for key, value in row.items()}
    assert merged["labels"] == ["chair #7"]
    assert merged["class_guesses"] == ["chair 100 %"]
    assert merged["size_m"] == ["0.60 x 0.40 x 0.20"]
    told = [(row["frame"], row["text"][0]) for row in rows if "text" in row]
    assert told[0] == (0, "#5 was the same thing as chair #7, and is part of it now")


def test_times_seen_are_a_curve_that_ends_at_their_number(recording):
    curve = [(r["frame"], r["scalars"][0]) for r in recording[f"{paths.OBSERVATIONS}/chair_7"] if "scalars" in r]
    assert curve == [(0, 1.0), (1, 2.0), (2, 3.0), (3, 4.0)]


def test_lives_are_told_in_one_text(recording):
    text = recording[paths.LIVES][-1]["text"][0]
    assert "### chair #7\n" in text
    assert "- frame 2: #5 was the same thing as chair #7" in text


def test_stages_are_plotted_one_upon_the_other(recording):
    assert [row["scalars"] for row in recording[paths.STAGES] if "scalars" in row] == [
        [2.5, 2.5 + index] for index in range(4)
    ]
    assert recording[f"{paths.STAGE_LEGEND}/names"][-1]["labels"] == ["vote", "lift"]
    assert all(row["scalars"] == [2.0, 1.0] for row in recording[paths.INSTANCES] if "scalars" in row)


def test_the_card_counts_frames_objects_and_the_way(recording):
    text = recording[paths.SUMMARY][-1]["text"][0]
    assert "**4** frames mapped, **1** left out" in text
    assert "**1** objects, **0** walls" in text
    assert "**0.0 m** walked" in text
    assert text.startswith("**Left out: frame 4**, the depth image is empty")
    assert recording[paths.POSE_SUMMARY][-1]["text"][0].startswith("**Left out: frame 4**")


def test_events_tell_what_happened_and_why(recording):
    told = [(row["level"][0], row["text"][0]) for row in recording[paths.EVENTS] if row["frame"] == 1]
    assert sorted(told) == [
        ("INFO", "#2 is dropped: it was not seen again, or looked through"),
        ("INFO", "#5 was the same thing as chair #7, and is part of it now"),
        ("INFO", "#9 appears: it is not #3, which is too far: 10 % overlap, cost 0.86 > gate 0.45"),
    ]
    skipped = [(row["level"][0], row["text"][0]) for row in recording[paths.EVENTS] if row["frame"] == 4]
    assert skipped == [("WARN", "skipped frame 4: the depth image is empty")]


def test_decisions_name_cost_and_runner_up(recording):
    text = recording[paths.DECISIONS][0]["text"][0]
    assert "| 0 | matched | #7 | 0.14 | 0.10 | 0.20 | #3 0.86 |" in text
    assert "| 1 | born | #8 |  |  |  | #3 0.86 |" in text


def test_depth_survives_to_the_millimetre(recording):
    blob = np.array(recording[paths.DEPTH][1]["blob"][0], np.uint8)
    assert (cv2.imdecode(blob, cv2.IMREAD_UNCHANGED) == 1000 * WALL_M).all()


def test_what_grows_is_the_surface_of_the_volume(recording):
    logged = [row for entity, rows in recording.items() if entity.startswith(f"{paths.GROWING}/") for row in rows]
    grown = np.concatenate([row["vertex_positions"] for row in logged if row["frame"] == 0])
    assert len(grown) > 50
    assert np.abs(grown[:, 2] - WALL_M).max() < 0.02


def test_the_finished_surface_replaces_what_grew(recording):
    assert len(recording[paths.SURFACE][0]["triangle_indices"]) > 100
    cleared = [row for row in recording[paths.GROWING] if row.get("is_recursive") == [True]]
    assert [row["frame"] for row in cleared] == [5]


def test_small_images_have_a_camera_that_fits(tmp_path):
    large = Intrinsics(640, 480, 500.0, 500.0, 319.5, 239.5)
    timeline = Timeline(tmp_path / "large.rrd", large, TimelineConfig(raster_max_edge=100))
    timeline.close()
    pinhole = chunks_of(tmp_path / "large.rrd")[paths.DEPTH][0]
    assert pinhole["resolution"] == [[92.0, 69.0]]  # every 7th pixel
    columns = np.array(pinhole["image_from_camera"][0]).reshape(3, 3)
    assert columns[0, 0] == pytest.approx(500 / 7)
    assert columns[2, 0] == pytest.approx(319.5 / 7 + 0.5)


def test_close_is_final_and_a_failing_file_does_not_end_the_run(tmp_path, monkeypatch):
    timeline = Timeline(tmp_path / "broken.rrd", CAMERA, TimelineConfig())

    def no_space(**_: object) -> None:
        raise RuntimeError("no space left")

    monkeypatch.setattr(timeline._log._streams[0], "flush", no_space)
    with pytest.warns(UserWarning, match="no space left"):
        timeline.close()
    timeline.close()


def test_carved_away_surface_vanishes_from_its_chunk(tmp_path):
    path = tmp_path / "carved.rrd"
    mapper = ScriptedMapper()
    timeline = Timeline(path, CAMERA, TimelineConfig(surface_every=1, surface_growth=1.1))
    timeline.show(frame(0), mapper.step(0), mapper, {})
    step = mapper.step(1)
    for weight in mapper.voxels.pages.views("weight"):
        weight.zero_()
    timeline.show(frame(1), step, mapper, {})
    timeline.close()
    last = [rows[-1] for entity, rows in chunks_of(path).items() if entity.startswith(f"{paths.GROWING}/")]
    assert last
    assert all(row["frame"] == 1 and "is_recursive" in row for row in last)


def test_the_null_timeline_takes_the_same_calls():
    for name, method in inspect.getmembers(NullTimeline, inspect.isfunction):
        assert inspect.signature(method) == inspect.signature(getattr(Timeline, name)), name
    shown = {name for name in vars(Timeline) if not name.startswith("_")}
    of_checkpoints = {"log", "state", "written"}
    assert shown - of_checkpoints == {name for name in vars(NullTimeline) if not name.startswith("_")}


def test_real_frames_fit_the_budget(real_data, tmp_path):
    """70 KB a frame at most: so few frames take 55 with the layout, which is there once; the rest is for the map."""
    files = sorted((real_data / "redkitchen").glob("frame-*.color.jpg"))[:300:30]
    camera = Intrinsics(640, 480, 585.0, 585.0, 320.0, 240.0)
    timeline = Timeline(tmp_path / "real.rrd", camera, TimelineConfig())
    mapper = ScriptedMapper()
    empty = replace(mapper.step(0), changed_blocks=np.zeros((0, 3), np.int32), decisions=())
    for index, file in enumerate(files):
        rgb = cv2.cvtColor(cv2.imread(str(file)), cv2.COLOR_BGR2RGB)
        raw = cv2.imread(str(file).replace("color.jpg", "depth.png"), cv2.IMREAD_UNCHANGED)
        depth = np.where(raw == 65535, 0, raw).astype(np.float32) / 1000
        ids = np.add.outer(np.arange(480) // 96 * 25, (np.arange(640) + 7 * index) // 128).astype(np.int32)
        timeline.show(Frame(index, 0.0, rgb, depth, camera, np.eye(4)), replace(empty, id_image=ids), mapper, {})
    timeline.close()
    assert (tmp_path / "real.rrd").stat().st_size / len(files) < 55_000


def test_empty_mesh_leaves_the_points(tmp_path):
    mapper = ScriptedMapper()
    timeline = Timeline(tmp_path / "short.rrd", CAMERA, TimelineConfig())
    timeline.show(frame(0), mapper.step(0), mapper, {})
    none = np.zeros((0, 3), np.int32)
    mesh = LabelledMesh(none.astype(np.float32), none.astype(np.uint8), none[:, 0], none)
    timeline.finish(SimpleNamespace(objects=(), mesh=mesh, up=None))
    timeline.close()
    recording = chunks_of(tmp_path / "short.rrd")
    assert paths.SURFACE not in recording
    assert paths.GROWING not in recording
