"""Parts of a mapped room: children of their wholes in the map, its files, its answers and its graph."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import razer
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.boxes.oriented_box import OrientedBox
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.query.part_answers import better_parts
from razer.query.ranking import PRESENT
from razer.query.text_queries import TextQueryEncoder
from razer.semantics.labelling import Segment
from razer.semantics.scene_graph import scene_graph
from razer.vocabulary import Category

NAMES = ("chair", "chair leg", "table", "lamp")


class WholesAndParts:
    """All things and all large parts of them, without names."""

    def segment(self, frame: Frame) -> Masks:
        ids, parts = frame.instance_ids, frame.part_ids
        shown = [i for i in np.unique(ids).tolist() if i > 0 and frame.instance_classes.get(i) not in ("wall", "floor")]
        masks = [ids == i for i in shown]
        masks += [m for i in shown for p in range(1, 20) if (m := (ids == i) & (parts == p)).sum() > 60]
        return Masks(np.array(masks), np.full(len(masks), 0.9, np.float32))


@pytest.fixture(scope="module")
def mapped():
    """A map with parts, and the same at the granularity of parts."""
    config = razer.MapperConfig.model_validate({"voxels": {"voxel_size_m": 0.05}})
    mapper = razer.Mapper(config, WholesAndParts(), "oracle")
    room = SyntheticRoom(0, 12, 160, 120)
    for index in range(len(room)):
        mapper.step(room[index])
    wholes = mapper.finish()
    mapper.config = config.model_copy(update={"granularity": "part"})
    return wholes, mapper.snapshot()


def test_parts_lie_on_their_wholes(mapped):
    panoptic = mapped[0]
    ids = {o.id for o in panoptic.objects}
    assert len(panoptic.parts) > 3
    assert min(part.id for part in panoptic.parts) > max(ids)
    assert {o.part_of for o in panoptic.objects} == {None}
    for part in panoptic.parts:
        rows = panoptic.vertex_parts == part.id
        assert part.part_of in ids
        assert part in panoptic.parts_of(part.part_of)
        assert set(panoptic.mesh.instances[rows].tolist()) == {part.part_of}
        assert rows.sum() == part.n_vertices > 0
        assert len(part.embeddings)
        inside = (
            np.abs((panoptic.mesh.vertices[rows] - part.box.center) @ part.box.rotation) <= part.box.extent / 2 + 0.05
        )
        assert inside.mean() > 0.9


def test_parts_follow_corrected_poses(mapped):
    """All frames are moved by a metre, and so is each part."""
    shift = np.array([1.0, 0, 0])
    settings = {"voxels": {"voxel_size_m": 0.05}, "reintegration": {"enabled": True}}
    mapper = razer.Mapper(razer.MapperConfig.model_validate(settings), WholesAndParts(), "oracle")
    room, poses = SyntheticRoom(0, 12, 160, 120), {}
    for index in range(len(room)):
        mapper.step(room[index])
        poses[index] = room[index].pose.copy()
        poses[index][:3, 3] += shift
    mapper.move(poses)
    moved, expected = mapper.finish(), mapped[0]
    centers = np.array([part.box.center for part in expected.parts]) + shift
    nearest = [np.linalg.norm(centers - part.box.center, axis=1).min() for part in moved.parts]
    assert len(moved.parts) >= 0.8 * len(expected.parts)
    assert np.median(nearest) < 0.03
    assert {part.part_of for part in moved.parts} <= {o.id for o in moved.objects}


def test_at_the_granularity_of_parts_they_are_instances(mapped):
    wholes, parts = mapped
    assert parts.parts == ()
    assert parts.vertex_parts is None
    assert {o.part_of for o in parts.objects if o.part_of} == {part.part_of for part in wholes.parts}
    assert len(parts.objects) > len(wholes.objects)
    counts = np.bincount(parts.mesh.instances)
    assert all(counts[o.id] == o.n_vertices for o in parts.objects if o.id < len(counts))
    assert wholes.in_parts().mesh.instances.tolist() == parts.mesh.instances.tolist()


def test_parts_are_saved_and_open_again(mapped, tmp_path):
    live = mapped[0]
    live.save(tmp_path)
    saved = razer.load_map(tmp_path)
    np.testing.assert_array_equal(saved.vertex_parts, live.vertex_parts)
    for ours, theirs in zip(saved.parts, live.parts, strict=True):
        assert (ours.id, ours.part_of, ours.n_vertices) == (theirs.id, theirs.part_of, theirs.n_vertices)
        np.testing.assert_array_equal(ours.embeddings, theirs.embeddings)
    assert "parts" in json.loads((tmp_path / "instances.json").read_text())
    # A map without parts takes its place: nothing of them stays.
    replace(live, parts=(), vertex_parts=None).save(tmp_path)
    assert not (tmp_path / "parts.npz").exists()
    assert razer.load_map(tmp_path).parts == ()


def test_damaged_parts_are_said_in_one_line(mapped, tmp_path):
    mapped[0].save(tmp_path)
    np.savez(tmp_path / "parts.npz", format=1, vertices=np.array([10**6]), parts=np.array([1]))
    with pytest.raises(BadInput, match=r"parts\.npz"):
        razer.load_map(tmp_path)
    (tmp_path / "parts.npz").unlink()
    with pytest.raises(BadInput, match=r"parts\.npz"):
        razer.load_map(tmp_path)


class Names:
    """A table of names with unit vectors of their own."""

    known_names = NAMES

    def embed_texts(self, texts):
        if unknown := set(texts) - set(NAMES):
            raise BadInput(f"the table has no {unknown}")
        return np.eye(len(NAMES), dtype=np.float32)[[NAMES.index(text) for text in texts]]


def an_object(number, vector, part_of=None):
    box = OrientedBox(np.zeros(3), np.eye(3), np.ones(3))
    vectors = np.array([vector], np.float32) / np.linalg.norm(vector)
    return MapObject(number, None, 1.0, box, 10, 10, 5, 0, 9, vectors, np.ones(1), part_of=part_of)


@pytest.fixture
def furnished():
    """A chair with a leg and a seat that looks a little more like a chair than the chair does; a table."""
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]], np.float32)
    instances, labels = np.array([1, 1, 1, 2, 2, 2], np.int32), np.array([11, 12, 0, 0, 0, 0], np.int32)
    mesh = LabelledMesh(places, np.zeros((6, 3), np.uint8), instances, np.array([[0, 1, 2], [3, 4, 5]], np.int32))
    objects = an_object(1, [1.0, 0.2, 0, 0]), an_object(2, [0, 0, 1.0, 0])
    parts = an_object(11, [0.3, 1.0, 0, 0], 1), an_object(12, [1.0, 0.19, 0, 0], 1)
    return PanopticMap(objects, mesh, TextQueryEncoder(Names()), parts=parts, vertex_parts=labels)


def test_a_part_is_an_answer_where_it_fits_better_than_its_whole(furnished):
    hits = {text: [hit.object.id for hit in furnished.query(text).hits] for text in NAMES}
    assert hits["chair leg"][0] == 11
    assert hits["chair"] == [1]
    assert hits["table"] == [2]
    assert hits["lamp"] == []
    image = furnished.query_image(np.array([0.3, 1.0, 0, 0], np.float32) / np.float32(np.hypot(0.3, 1)))
    assert image.hits[0].object.part_of == 1


def test_of_two_that_are_certain_the_whole_is_meant():
    scores = np.array([0.95, 0.95, 1 - 1e-9, 0.5, 0.7])
    of_wholes = np.array([0.93, 0.8, 0.995, 0.0, 0.0])
    assert better_parts(scores, of_wholes, PRESENT).tolist() == [1, 4]


def test_parts_change_no_score_of_wholes(furnished):
    without = replace(furnished, parts=(), vertex_parts=None)
    for text in NAMES:
        whole_hits = [(h.object.id, h.score) for h in furnished.query(text).hits if h.object.part_of is None]
        assert whole_hits == [(h.object.id, h.score) for h in without.query(text).hits]


def test_the_mesh_shows_a_part_where_it_is_a_hit(furnished):
    assert furnished.mesh_of([11]).instances.tolist() == [11, 1, 1, 2, 2, 2]
    assert furnished.mesh_of([1]).instances.tolist() == [1, 1, 1, 2, 2, 2]


def test_parts_are_nodes_of_the_graph_and_part_of_their_whole(furnished):
    chair, wall = Category(1, "chair", 5, "", False), Category(2, "wall", 1, "", True)
    graph = scene_graph(furnished, [Segment(1, chair, 0.9, (1,)), Segment(2, wall, 0.9, (2,))], np.array([0.0, 0, 1]))
    nodes = {node["id"]: node for node in graph["nodes"]}
    assert set(nodes) == {1, 2, 11, 12}
    assert (nodes[11]["class"], nodes[11]["part_of"]) == ("chair part", 1)
    edges = [(e["from"], e["to"]) for e in graph["edges"] if e["relation"] == "part of"]
    assert edges == [(11, 1), (12, 1)]
    of_stuff = scene_graph(furnished, [Segment(1, wall, 0.9, (1,))], np.array([0.0, 0, 1]))
    assert [node["id"] for node in of_stuff["nodes"]] == [1]
