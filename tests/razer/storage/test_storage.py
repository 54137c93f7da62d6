"""Files of the method: round trips, what another reader sees, and plain words for files that are none."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import open3d as o3d
import pytest
from numpy.testing import assert_allclose

import razer.volume.blocks.block_pages
from razer.class_votes import ClassVote
from razer.errors import BadInput
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.storage.embeddings_npz import write_embeddings_npz
from razer.storage.instances_json import read_instances_json, write_instances_json
from razer.storage.ply import read_mesh_ply, write_mesh_ply
from razer.storage.volume_npz import load_voxels, save_voxels
from razer.volume.mesh_extraction import extract_mesh
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, contents, frame_of, look, moved, pose, random_box, same_contents, unit


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 64)


def voted_map() -> VoxelMap:
    """Two walls under votes for 1 to 6, of which 5 was fused into 2 and 6 was forgotten; not yet settled."""
    voxels = VoxelMap(COARSE)
    voxels.admit(7)
    rng = np.random.default_rng(0)
    for at in (pose(), pose((0.2, 0.1, 0), (0, 15, 0))):
        for _ in range(4):
            frame = frame_of(np.full((120, 160), 1.5), at)
            voxels.integrate(frame)
            cells = look(frame).cells
            voxels.vote(cells, rng.integers(0, 7, len(cells)).astype(np.int32))
    voxels.replace(5, 2)
    voxels.replace(6, 0)
    return voxels


def test_map_round_trip_is_bit_exact(tmp_path: Path) -> None:
    voxels = voted_map()
    save_voxels(tmp_path / "map.npz", voxels)
    loaded = load_voxels(tmp_path / "map.npz")
    before, after = contents(voxels), contents(loaded)
    assert same_contents(before, after)
    assert {name: a.dtype for name, a in before.items()} == {name: a.dtype for name, a in after.items()}
    assert loaded.settings == voxels.settings
    assert loaded.newest_id == 7
    save_voxels(tmp_path / "again.npz", loaded)
    assert same_contents(after, contents(load_voxels(tmp_path / "again.npz")))


def test_saved_labels_have_all_fusions_applied(tmp_path: Path) -> None:
    voxels = voted_map()
    assert {5, 6} <= set(np.unique(contents(voxels)["ids"]))
    save_voxels(tmp_path / "map.npz", voxels)
    held = contents(load_voxels(tmp_path / "map.npz"))
    assert set(np.unique(held["ids"])) == set(np.unique(held["label"])) == {0, 1, 2, 3, 4}


def test_a_loaded_map_goes_on_as_the_saved_one_would(tmp_path: Path) -> None:
    voxels = voted_map()
    save_voxels(tmp_path / "map.npz", voxels)
    loaded = load_voxels(tmp_path / "map.npz")
    frame = frame_of(np.full((120, 160), 2.2), pose((0, 0, 0.3)))
    for each in (voxels, loaded):
        each.admit(8)
        each.integrate(frame)
        each.vote(look(frame).cells, np.full(len(look(frame).cells), 8, np.int32))
        each.replace(3, 8)
    assert same_contents(contents(voxels), contents(loaded))
    one, other = extract_mesh(voxels), extract_mesh(loaded)
    assert all(np.array_equal(a, vars(other)[name]) for name, a in vars(one).items())


def test_an_empty_map_survives_the_round_trip(tmp_path: Path) -> None:
    save_voxels(tmp_path / "map.npz", VoxelMap(COARSE))
    assert load_voxels(tmp_path / "map.npz").n_blocks == 0


def test_the_map_file_is_compressed_arrays_in_sorted_order(tmp_path: Path) -> None:
    voxels = voted_map()
    save_voxels(tmp_path / "map.npz", voxels)
    with np.load(tmp_path / "map.npz", allow_pickle=False) as archive:
        keys = archive["keys"]
        assert int(archive["format"]) == 1
    assert np.array_equal(keys, np.unique(keys, axis=0))
    assert len(keys) == voxels.n_blocks
    assert (tmp_path / "map.npz").stat().st_size < voxels.n_blocks * 4096 * 48 / 4


def damage(path: Path, kind: str) -> None:
    data = bytearray(path.read_bytes())
    match kind:
        case "missing":
            path.unlink()
            return
        case "empty":
            data = bytearray()
        case "text":
            data = bytearray(b"not a map at all\n" * 50)
        case "cut short":
            data = data[: len(data) // 2]
        case "overwritten":
            data[200 : len(data) // 3] = bytes(len(data) // 3 - 200)
        case "one bit":
            data[len(data) // 4] ^= 0x10
    path.write_bytes(data)


@pytest.mark.parametrize("kind", ["missing", "empty", "text", "cut short", "overwritten", "one bit"])
def test_a_damaged_map_is_refused_in_plain_words(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "map.npz"
    save_voxels(path, voted_map())
    damage(path, kind)
    with pytest.raises(BadInput, match=r"map\.npz") as error:
        load_voxels(path)
    assert "\n" not in str(error.value)


def test_archives_that_are_no_map_are_refused(tmp_path: Path) -> None:
    save_voxels(tmp_path / "map.npz", voted_map())
    with np.load(tmp_path / "map.npz") as archive:
        good = dict(archive)
    changes: list[dict] = [{"format": np.array(2)}, {"settings": np.array("{}}")}, {"settings": np.array('{"a": 1}')}]
    for change in changes:
        np.savez(tmp_path / "other.npz", **{**good, **change})
        with pytest.raises(BadInput, match=r"other\.npz"):
            load_voxels(tmp_path / "other.npz")
    for left_out in good:
        np.savez(tmp_path / "other.npz", **{name: a for name, a in good.items() if name != left_out})
        with pytest.raises(BadInput, match=r"other\.npz"):
            load_voxels(tmp_path / "other.npz")
    np.save(tmp_path / "single.npy", np.zeros(3))
    with pytest.raises(BadInput, match=r"single\.npy"):
        load_voxels(tmp_path / "single.npy")


def small_mesh() -> LabelledMesh:
    rng = np.random.default_rng(0)
    return LabelledMesh(
        rng.normal(size=(20, 3)).astype(np.float32),
        rng.integers(0, 256, (20, 3)).astype(np.uint8),
        rng.integers(0, 100_000, 20).astype(np.int32),
        rng.integers(0, 20, (31, 3)).astype(np.int32),
    )


NOTHING = LabelledMesh(
    np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint8), np.zeros(0, np.int32), np.zeros((0, 3), np.int32)
)


@pytest.mark.parametrize("mesh", [small_mesh(), NOTHING], ids=["small", "empty"])
def test_mesh_round_trip(tmp_path: Path, mesh: LabelledMesh) -> None:
    write_mesh_ply(tmp_path / "mesh.ply", mesh)
    loaded = read_mesh_ply(tmp_path / "mesh.ply")
    for name, array in vars(mesh).items():
        assert np.array_equal(vars(loaded)[name], array), name
        assert vars(loaded)[name].dtype == array.dtype


SIZES = {"float": "<f4", "uchar": "u1", "int": "<i4"}


def test_mesh_by_a_reader_that_only_knows_the_ply_header(tmp_path: Path) -> None:
    mesh = small_mesh()
    write_mesh_ply(tmp_path / "mesh.ply", mesh)
    data = (tmp_path / "mesh.ply").read_bytes()
    header, _, body = data.partition(b"end_header\n")
    lines = [line.split() for line in header.decode("ascii").splitlines()]
    assert lines[:2] == [["ply"], ["format", "binary_little_endian", "1.0"]]
    assert [line[1:] for line in lines if line[0] == "element"] == [["vertex", "20"], ["face", "31"]]
    properties = [line[1:] for line in lines if line[0] == "property"]
    assert properties[-1] == ["list", "uchar", "int", "vertex_indices"]
    vertex = np.dtype([(name, SIZES[kind]) for kind, name in properties[:-1]])
    vertices = np.frombuffer(body, vertex, 20)
    assert np.array_equal(np.stack([vertices[n] for n in ("x", "y", "z")], axis=1), mesh.vertices)
    assert np.array_equal(np.stack([vertices[n] for n in ("red", "green", "blue")], axis=1), mesh.colors)
    assert np.array_equal(vertices["instance"], mesh.instances)
    faces = np.frombuffer(body[vertices.nbytes :], np.dtype([("n", "u1"), ("corners", "<i4", 3)]))
    assert (faces["n"] == 3).all()
    assert np.array_equal(faces["corners"], mesh.triangles)


def test_mesh_as_open3d_reads_it(tmp_path: Path) -> None:
    mesh = small_mesh()
    write_mesh_ply(tmp_path / "mesh.ply", mesh)
    found = o3d.io.read_triangle_mesh(tmp_path / "mesh.ply")
    assert_allclose(np.asarray(found.vertices), mesh.vertices)
    assert np.array_equal(np.asarray(found.triangles), mesh.triangles)
    assert_allclose(np.asarray(found.vertex_colors), mesh.colors / 255)


FOREIGN_PLY = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0.5\n"


@pytest.mark.parametrize(
    "content", [b"", b"hello\n", b"\x00\xff" * 500, FOREIGN_PLY, b"ply\nelement vertex\nend_header\n"]
)
def test_files_that_are_no_mesh_are_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "mesh.ply").write_bytes(content)
    with pytest.raises(BadInput, match=r"mesh\.ply"):
        read_mesh_ply(tmp_path / "mesh.ply")


def test_a_mesh_cut_short_is_refused(tmp_path: Path) -> None:
    write_mesh_ply(tmp_path / "mesh.ply", small_mesh())
    data = (tmp_path / "mesh.ply").read_bytes()
    (tmp_path / "mesh.ply").write_bytes(data[:-5])
    with pytest.raises(BadInput, match="cut short"):
        read_mesh_ply(tmp_path / "mesh.ply")


def some_object(number: int, class_name: str | None = None, n_hypotheses: int = 1) -> MapObject:
    rng = np.random.default_rng(number)
    vectors = np.stack([unit(*rng.normal(size=4)) for _ in range(n_hypotheses)] or [np.zeros(4)])[:n_hypotheses]
    return MapObject(
        id=number,
        class_name=class_name,
        score=0.75,
        box=moved(random_box(rng), pose((1, 2, 3))),
        n_voxels=10 * number,
        n_vertices=20 * number,
        observations=7,
        first_frame=3,
        last_frame=90,
        embeddings=vectors.astype(np.float32),
        weights=np.full(n_hypotheses, 1 / max(n_hypotheses, 1)),
    )


def test_instances_follow_the_contract(tmp_path: Path) -> None:
    objects = (some_object(1, "chair"), some_object(4))
    write_instances_json(tmp_path / "instances.json", objects, np.array([0.0, -1, 0]))
    content = json.loads((tmp_path / "instances.json").read_text(encoding="utf-8"))
    assert set(content) == {"format", "frame", "up", "instances"}
    assert content["format"] == 1
    assert content["frame"] == "world, metres, right-handed"
    assert content["up"] == [0, -1, 0]
    for entry, found in zip(content["instances"], objects, strict=True):
        assert set(entry) == {
            "id", "class", "score", "center", "extent", "rotation",
            "n_voxels", "n_vertices", "observations", "first_frame", "last_frame", "best_views",
        }  # fmt: skip
        rotation = np.array(entry["rotation"])
        assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
        assert np.linalg.det(rotation) == pytest.approx(1, abs=1e-6)
        signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        corners = np.array(entry["center"]) + (signs * entry["extent"]) @ rotation.T
        assert_allclose(corners, found.box.corners(), atol=1e-4)
        assert (entry["n_voxels"], entry["n_vertices"]) == (found.n_voxels, found.n_vertices)
        assert (entry["observations"], entry["first_frame"], entry["last_frame"]) == (7, 3, 90)
        assert 0 <= entry["score"] <= 1
    assert [(e["id"], e["class"]) for e in content["instances"]] == [(1, "chair"), (4, None)]


def test_stuff_is_said_of_stuff_alone(tmp_path: Path) -> None:
    objects = (some_object(1, "chair"), replace(some_object(2, "floor"), is_stuff=True))
    write_instances_json(tmp_path / "instances.json", objects)
    content = json.loads((tmp_path / "instances.json").read_text(encoding="utf-8"))
    assert [entry.get("stuff") for entry in content["instances"]] == [None, True]
    assert [o.is_stuff for o in read_instances_json(tmp_path / "instances.json")[0]] == [False, True]


def test_votes_for_classes_come_back_and_are_not_needed(tmp_path: Path) -> None:
    votes = (ClassVote("armchair", 3, 40, 12.5, 0.62), ClassVote("couch", 5, 2, 0.75, 0.8125))
    path = tmp_path / "instances.json"
    write_instances_json(path, (replace(some_object(1, "couch"), class_votes=votes), some_object(2)))
    assert [o.class_votes for o in read_instances_json(path)[0]] == [votes, ()]
    content = json.loads(path.read_text(encoding="utf-8"))
    assert "class_votes" not in content["instances"][1]
    for key, value in (("frames", 0), ("weight", -1), ("score", float("nan")), ("class", 7)):
        spoilt = json.loads(path.read_text(encoding="utf-8"))
        spoilt["instances"][0]["class_votes"][0][key] = value
        (tmp_path / "spoilt.json").write_text(json.dumps(spoilt), encoding="utf-8")
        with pytest.raises(ValueError, match="NaN is not finite" if value != value else "no vote"):
            read_instances_json(tmp_path / "spoilt.json")


def test_instances_of_an_empty_map_with_an_unknown_up(tmp_path: Path) -> None:
    write_instances_json(tmp_path / "instances.json", ())
    content = json.loads((tmp_path / "instances.json").read_text(encoding="utf-8"))
    assert content["up"] is None
    assert content["instances"] == []


def test_embeddings_have_a_row_for_each_hypothesis(tmp_path: Path) -> None:
    objects = (some_object(2, n_hypotheses=3), some_object(3, n_hypotheses=0), some_object(9, n_hypotheses=1))
    write_embeddings_npz(tmp_path / "embeddings.npz", objects)
    with np.load(tmp_path / "embeddings.npz", allow_pickle=False) as archive:
        assert int(archive["format"]) == 1
        assert archive["ids"].tolist() == [2, 2, 2, 9]
        assert np.array_equal(archive["embeddings"], np.concatenate([o.embeddings for o in objects]))
        assert_allclose(archive["weights"], [1 / 3, 1 / 3, 1 / 3, 1])


def test_embeddings_of_an_empty_map(tmp_path: Path) -> None:
    write_embeddings_npz(tmp_path / "embeddings.npz", ())
    with np.load(tmp_path / "embeddings.npz", allow_pickle=False) as archive:
        assert len(archive["ids"]) == len(archive["embeddings"]) == len(archive["weights"]) == 0
