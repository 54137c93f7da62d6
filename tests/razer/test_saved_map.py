"""Saved maps: what `save` writes opens again as it was, also the folder of a run of format 1."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import razer
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.volume.mesh_extraction import extract_mesh

FORMAT_1 = Path(__file__).resolve().parents[1] / "fixtures" / "run_format_1"
FILES = ("instances.json", "mesh.ply", "embeddings.npz", "map.npz", "config.toml")


@pytest.fixture(scope="module")
def live():
    """A small room, mapped with perfect masks."""
    config = razer.MapperConfig.model_validate({"voxels": {"voxel_size_m": 0.05}})
    mapper = razer.Mapper(config, "oracle", "oracle")
    room = SyntheticRoom(0, 12, 160, 120)
    for index in range(len(room)):
        mapper.step(room[index])
    return mapper.finish()


def test_a_run_of_format_1_opens():
    saved = razer.load_map(FORMAT_1)
    assert [(o.id, o.class_name) for o in saved.objects][:4] == [(4, "chair"), (5, "chair"), (7, "chair"), (8, "table")]
    assert len(saved.objects) == 9
    assert {o.class_votes for o in saved.objects} == {()}  # there were none then
    assert saved.mesh.vertices.shape == (117, 3)
    np.testing.assert_allclose(saved.up, [0, 0, 1], atol=0.01)
    assert saved.volume.n_blocks == 13
    assert {hit.object.class_name for hit in saved.query("a chair").hits} == {"chair"}


def test_what_is_saved_again_is_the_same_to_the_byte(tmp_path):
    razer.load_map(FORMAT_1).save(tmp_path / "again")
    for name in set(FILES) - {"map.npz"}:
        assert (tmp_path / "again" / name).read_bytes() == (FORMAT_1 / name).read_bytes(), name
    with np.load(tmp_path / "again" / "map.npz") as again, np.load(FORMAT_1 / "map.npz") as before:
        assert again.files == before.files
        # Settings that there are since then are added, with what the map was made with.
        old, new = (json.loads(str(arrays["settings"])) for arrays in (before, again))
        assert new == old | {"surface_share": 2.0, "vertex_labels": "votes", "seam_rings": 3}
        for name in set(before.files) - {"settings"}:
            assert again[name].tobytes() == before[name].tobytes(), name


def test_the_volume_of_a_run_of_format_1_has_the_surface_that_it_had():
    """A voxel was surface from three observations on, however often its block was seen."""
    saved = razer.load_map(FORMAT_1)
    anew = extract_mesh(saved.volume)
    for part in ("vertices", "instances", "triangles", "colors"):
        np.testing.assert_array_equal(getattr(anew, part), getattr(saved.mesh, part))


def test_a_volume_of_format_1_that_took_all_that_was_seen_opens(tmp_path):
    folder = shutil.copytree(FORMAT_1, tmp_path / "run")
    with np.load(folder / "map.npz") as before:
        settings = json.loads(str(before["settings"])) | {"surface_weight": 0.0}
        np.savez_compressed(folder / "map.npz", **{**before, "settings": np.array(json.dumps(settings))})
    volume = razer.load_map(folder).volume
    assert (volume.settings.surface_weight, volume.settings.surface_share) == (1.0, 2.0)


def test_a_live_map_comes_back_as_it_was(live, tmp_path):
    live.save(tmp_path / "map")
    assert {path.name for path in (tmp_path / "map").iterdir()} == set(FILES)
    saved = razer.load_map(tmp_path / "map")
    assert [(o.id, o.class_name, o.n_vertices) for o in saved.objects] == [
        (o.id, o.class_name, o.n_vertices) for o in live.objects
    ]
    for ours, theirs in zip(saved.objects, live.objects, strict=True):
        np.testing.assert_array_equal(ours.embeddings, theirs.embeddings)
        np.testing.assert_allclose(ours.box.center, theirs.box.center, atol=1e-5)
    for part in ("vertices", "instances", "triangles", "colors"):
        np.testing.assert_array_equal(getattr(saved.mesh, part), getattr(live.mesh, part))
    assert saved.volume.n_blocks == live.volume.n_blocks
    np.testing.assert_allclose(saved.up, live.up, atol=1e-5)


def test_a_saved_map_answers_as_the_live_one(live, tmp_path):
    live.save(tmp_path / "map")
    saved = razer.load_map(tmp_path / "map")
    for text in ("a chair", "table", "a submarine"):
        before, after = live.query(text), saved.query(text)
        assert [(h.object.id, h.score) for h in before.hits] == [(h.object.id, h.score) for h in after.hits]
    assert live.query("a chair").found


def test_saving_replaces_a_map_and_nothing_else(live, tmp_path):
    live.save(tmp_path)
    live.save(tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.tex").write_text("years of work")
    with pytest.raises(razer.BadInput, match="holds something else"):
        live.save(other)
    assert [path.name for path in other.iterdir()] == ["thesis.tex"]
    run = shutil.copytree(FORMAT_1, other / "run")
    with pytest.raises(razer.BadInput, match="holds something else"):
        live.save(run)
    assert (run / "trajectory.txt").is_file()


def test_a_map_without_a_volume_leaves_none_of_an_older_map(live, tmp_path):
    live.save(tmp_path)
    replace(live, open_volume=None).save(tmp_path)
    assert not (tmp_path / "map.npz").exists()


def test_a_snapshot_is_saved_before_the_map_goes_on(tmp_path):
    mapper, room = razer.Mapper(segmenter="oracle", embedder="oracle"), SyntheticRoom(0, 4, 160, 120)
    mapper.step(room[0])
    snapshot = mapper.snapshot()
    snapshot.save(tmp_path / "first")
    mapper.step(room[1])
    with pytest.raises(razer.BadInput, match="since this snapshot"):
        _ = replace(snapshot).volume


@pytest.mark.parametrize(
    "fault",
    [
        {"class": ["chair"]}, {"class": 5}, {"center": [1.0]}, {"center": [1.0, 2.0, float("nan")]},
        {"extent": [1, 1, -1]}, {"rotation": [[1e308, 0, 0], [0, 1, 0], [0, 0, 1]]}, {"extent": [1e30, 1, 1]},
    ],
)  # fmt: skip
def test_instances_that_cannot_be_are_refused(tmp_path, fault):
    folder = shutil.copytree(FORMAT_1, tmp_path / "run")
    content = json.loads((folder / "instances.json").read_text())
    content["instances"][0] |= fault
    (folder / "instances.json").write_text(json.dumps(content))
    with pytest.raises(razer.BadInput, match="instances"):
        razer.load_map(folder)


@pytest.mark.parametrize("up", [[0, 0, 0], [float("nan"), 0, 1], [1, 0], "up"])
def test_a_direction_that_is_none_is_refused(tmp_path, up):
    folder = shutil.copytree(FORMAT_1, tmp_path / "run")
    content = json.loads((folder / "instances.json").read_text()) | {"up": up}
    (folder / "instances.json").write_text(json.dumps(content))
    with pytest.raises(razer.BadInput, match="instances"):
        razer.load_map(folder)


def test_the_volume_is_opened_when_it_is_needed(tmp_path):
    folder = shutil.copytree(FORMAT_1, tmp_path / "run")
    (folder / "map.npz").unlink()
    saved = razer.load_map(folder)
    assert saved.query("a chair").found
    with pytest.raises(razer.BadInput, match=r"no map\.npz"):
        _ = saved.volume


@pytest.mark.parametrize("name", ["instances.json", "mesh.ply", "embeddings.npz"])
def test_a_damaged_file_is_named(tmp_path, name):
    folder = shutil.copytree(FORMAT_1, tmp_path / "run")
    (folder / name).write_bytes((folder / name).read_bytes()[:50])
    with pytest.raises(razer.BadInput, match=name.split(".")[0]):
        razer.load_map(folder)


def test_another_embedder_can_be_given(tmp_path):
    class Silent:
        def embed(self, frame, masks):
            return np.zeros((len(masks), 4), np.float32)

    with pytest.raises(razer.BadInput, match="no text encoder"):
        razer.load_map(FORMAT_1, embedder=Silent()).query("a chair")
    with pytest.raises(razer.BadInput, match="trust-plugins"):
        razer.load_map(FORMAT_1, embedder="os:system").query("a chair")


def test_models_are_objects_names_or_settings():
    by_name = razer.Mapper(segmenter="oracle", embedder="oracle")
    by_object = razer.Mapper(segmenter=razer.make_segmenter("oracle"), embedder=razer.make_embedder("oracle", {}))
    settings = {"segmenter": {"name": "oracle"}, "embedder": {"name": "oracle"}}
    by_settings = razer.Mapper(razer.MapperConfig.model_validate(settings))
    assert by_name.config == by_object.config == by_settings.config
    assert razer.Mapper().config.segmenter.name == "geometric"
    with pytest.raises(razer.BadInput, match="unknown segmenter"):
        razer.Mapper(segmenter="no such")


def test_damaged_settings_are_one_plain_line_when_the_embedder_is_needed(tmp_path):
    folder = shutil.copytree(FORMAT_1, tmp_path / "run")
    (folder / "config.toml").write_text("[embedder]\nname = 5\noptions = 7\n")
    with pytest.raises(razer.BadInput, match=r"config\.toml is damaged") as refused:
        razer.load_map(folder).query("a chair")
    assert "\n" not in str(refused.value)
