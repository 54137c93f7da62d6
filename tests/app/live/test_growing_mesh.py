"""A growing mesh in chunks: put together it is the mesh of the whole map, and who looks is sent what changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.live.due_chunks import BLOCKS_PER_EDGE, DueChunks
from app.live.growing_mesh import GrowingMesh
from app.live.mesh_blocks import encode_blocks
from app.live.snapshot import Snapshot
from app.page.packet import unpack
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk, blocks_of, by_chunk
from razer.volume.marching_cubes import marching_cubes
from razer.volume.mesh_extraction import extract_part
from razer.volume.voxel_map import VoxelMap

SIZE_M = 0.05


@pytest.fixture(scope="module")
def mapped() -> tuple[VoxelMap, list[np.ndarray]]:
    """A volume, and the blocks that each of its frames changed."""
    voxels = VoxelMap(VoxelSettings(voxel_size_m=SIZE_M))
    room = SyntheticRoom(n_frames=6, width=160, height=120)
    return voxels, [voxels.integrate(room[index]) for index in range(6)]


def all_due(changes: list[np.ndarray]) -> DueChunks:
    due = DueChunks()
    for keys in changes:
        due.observe(keys)
    return due


def triangle_set(vertices: np.ndarray, triangles: np.ndarray) -> set[tuple]:
    corners = np.rint(vertices[triangles] / (SIZE_M / 1000)).astype(np.int64)
    return {tuple(sorted(map(tuple, triangle))) for triangle in corners.tolist()}


def snapshot(chunks, frame: int = 0, **fields) -> Snapshot:
    return Snapshot(frame, (), chunks, **fields)


def labelled(*labels: int) -> LabelledMesh:
    """One triangle, whose corners bear labels."""
    corners = np.eye(3, dtype=np.float32)
    return LabelledMesh(
        corners, np.zeros((3, 3), np.uint8), np.array(labels, np.int32), np.array([[0, 1, 2]], np.int32)
    )


def test_chunks_of_any_order_and_size_make_up_the_whole_mesh(mapped):
    voxels, changes = mapped
    due, growing = all_due(changes), GrowingMesh()
    while len(due):
        chunks = due.take(7)
        mesh = extract_part(voxels, blocks_of(chunks, BLOCKS_PER_EDGE))
        parts = by_chunk(mesh, SIZE_M * BLOCK * BLOCKS_PER_EDGE)
        growing.take(snapshot({chunk: parts.get(chunk, LabelledMesh.empty()) for chunk in chunks}))
    whole = growing.whole(np.zeros(0, np.int32))
    vertices, _, triangles = marching_cubes(voxels.pages, voxels.settings)
    assert triangle_set(whole.vertices, whole.triangles) == triangle_set(vertices, triangles)


def test_a_chunk_is_due_again_only_when_it_changed(mapped):
    _, changes = mapped
    due = all_due(changes)
    n_all = len(due)
    assert len(due.take(n_all)) == n_all
    assert len(due) == 0
    assert due.take(100) == []
    due.observe(changes[0][:1])
    reached = due.take(100)
    block = changes[0][0]
    assert Chunk(*(block // BLOCKS_PER_EDGE).tolist()) in reached
    assert len(reached) <= 8


def test_what_was_never_shown_comes_before_what_changed_a_little():
    due = DueChunks()
    old, new = np.array([[1, 1, 1]], np.int32), np.array([[101, 101, 101]], np.int32)
    for _ in range(10):
        due.observe(old)
    due.take(1)
    due.observe(old)
    due.observe(new)
    assert due.take(1) == [Chunk(50, 50, 50)]


def test_a_changed_block_reaches_the_chunks_below_it():
    due = DueChunks()
    due.observe(np.array([[2, 2, 2]], np.int32))  # the first block of its chunk
    assert set(due.take(100)) == {Chunk(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)}


def test_after_a_rebuild_all_chunks_are_due(mapped):
    due = all_due(mapped[1])
    n_all = len(due)
    due.take(n_all)
    due.all_changed()
    assert len(due) == n_all


def test_changes_since_a_revision_are_those_that_came_after_it():
    growing = GrowingMesh()
    first, second = Chunk(0, 0, 0), Chunk(0, 0, 1)
    growing.take(snapshot({first: labelled(1, 1, 1)}))
    growing.take(snapshot({second: labelled(1, 1, 1)}))
    assert growing.changes(0).keys() == {first, second}
    assert growing.changes(1).keys() == {second}
    assert growing.changes(2) == {}
    growing.take(snapshot({first: labelled(2, 2, 2)}))
    assert growing.changes(2).keys() == {first}


def test_surface_that_was_carved_away_vanishes():
    growing, chunk = GrowingMesh(), Chunk(0, 0, 0)
    growing.take(snapshot({chunk: labelled(1, 1, 1)}))
    growing.take(snapshot({chunk: LabelledMesh.empty()}))
    assert len(growing.whole(np.array([1], np.int32)).vertices) == 0
    _, sections = unpack(encode_blocks(growing.changes(1), 2, 0))
    assert sections["triangles"] == b""


def test_instances_that_were_fused_or_forgotten_are_renamed_in_what_was_sent_before():
    growing, chunk, other = GrowingMesh(), Chunk(0, 0, 0), Chunk(0, 0, 1)
    growing.take(snapshot({chunk: labelled(1, 2, 3), other: labelled(4, 4, 4)}))
    growing.take(snapshot({}, renamed={1: 2, 2: 5, 3: 0}))
    assert growing.changes(0)[chunk].instances.tolist() == [5, 5, 0]
    assert growing.changes(1).keys() == {chunk}


def test_only_known_instances_have_vertices():
    growing = GrowingMesh()
    growing.take(snapshot({Chunk(0, 0, 0): labelled(1, 2, 0)}))
    assert growing.whole(np.array([2], np.int32)).instances.tolist() == [0, 2, 0]


def test_blocks_are_read_again_as_they_were():
    blocks = {Chunk(0, 0, 1): labelled(1, 2, 3), Chunk(-1, 0, 0): replace(labelled(4, 5, 6))}
    header, sections = unpack(encode_blocks(blocks, 7, 3))
    assert (header["revision"], header["epoch"]) == (7, 3)
    assert [block["key"] for block in header["blocks"]] == [[0, 0, 1], [-1, 0, 0]]
    assert np.frombuffer(sections["instances"], "<i4").tolist() == [1, 2, 3, 4, 5, 6]
    assert np.frombuffer(sections["triangles"], "<u4").tolist() == [0, 1, 2, 0, 1, 2]
    assert np.frombuffer(sections["positions"], "<f4").reshape(-1, 3).tolist() == np.tile(np.eye(3), (2, 1)).tolist()
