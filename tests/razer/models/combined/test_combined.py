"""Combinations of segmenters by name: their parts, options, trust, settings and stored masks."""

from __future__ import annotations

import io
import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from app.pipeline.stored_masks import note_stored_masks
from app.settings.config_file import read_config
from data_tools import open_sequence
from razer.config import MapperConfig
from razer.errors import BadInput, UntrustedPlugin
from razer.frame import Frame, Intrinsics, Masks
from razer.mapper import Mapper
from razer.models import make_embedder, make_segmenter
from razer.models.combined.part_names import part_names
from razer.models.combined.segmenter import CombinedSegmenter
from razer.plugins import NO_TRUST, Trust
from razer.storage.settings_list import list_settings
from razer.storage.toml_text import toml_text
from tests.razer.models.semantic.test_semantic import picture
from tests.support.cli import QUICK, instances_of, razer, write_small_room
from tests.support.semantic_exports import write_semantic
from tests.support.yolo_exports import dense, write_export


class Whole:
    """One mask over all of the image."""

    def __init__(self, name: str = "box", score: float = 0.9) -> None:
        self.name, self.score = name, score

    def segment(self, frame: Frame) -> Masks:
        return Masks(np.ones((1, *frame.depth.shape), np.bool_), np.array([self.score], np.float32), (self.name,))


OUTSIDE = f"{__name__}:Whole"


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("yolo+semantic", {"yolo": "yolo", "semantic": "semantic"}),
        ("near=yolo + far=yolo+masks", {"near": "yolo", "far": "yolo", "masks": "masks"}),
        ("yolo+b=yolo", {"yolo": "yolo", "b": "yolo"}),
        ("yolo+my.models:Net", {"yolo": "yolo", "Net": "my.models:Net"}),
    ],
)
def test_parts_are_called_as_their_segmenters_or_as_said(name: str, parts: dict) -> None:
    assert part_names(name) == parts


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("yolo+yolo", {}, r"two parts called yolo: name them, as in a=yolo\+b=yolo"),
        ("yolo+", {}, r"write parts as in yolo\+semantic"),
        ("+yolo", {}, "write parts as in"),
        ("iou=yolo+semantic", {}, "write parts as in"),
        ("a b=yolo+semantic", {}, "write parts as in"),
        ("yolo+nothing", {"yolo": {"weights": "w"}}, "no model file w|unknown segmenter 'nothing'"),
        ("geometric+oracle", {"weights": "w"}, "has no part 'weights': options are those of its parts geometric, orac"),
        ("geometric+oracle", {"oracle": "full"}, r"segmenter\.options\.oracle = 'full': write .*oracle\.OPTION=VALUE"),
        ("geometric+oracle", {"iou": 0}, "iou is above 0 and up to 1, not 0"),
        ("geometric+oracle", {"iou": "half"}, "iou is above 0 and up to 1, not 'half'"),
        ("geometric+oracle", {"oracle": {"nois": "full"}}, "'oracle' does not take these options: .*'nois'"),
        ("a=oracle+b=oracle", {"b": {"nois": 1}}, "b: segmenter 'oracle' does not take these options"),
        ("masks+oracle", {}, "'masks' does not take these options: missing 1 option: 'folder'"),
    ],
)
def test_wrong_names_and_options_are_one_line(name: str, options: dict, said: str) -> None:
    with pytest.raises(BadInput, match=said) as refused:
        make_segmenter(name, options)
    assert "\n" not in str(refused.value)


def test_code_from_outside_is_trusted_where_the_combination_was_named() -> None:
    name = f"{OUTSIDE}+oracle"
    with pytest.raises(UntrustedPlugin):
        make_segmenter(name, trust=NO_TRUST)
    with pytest.raises(UntrustedPlugin):
        make_segmenter(name, trust=NO_TRUST.also(["other:Code+oracle"]))
    for trust in (NO_TRUST.also([name]), NO_TRUST.also([f"x={OUTSIDE}+yolo"]), Trust(everything=True)):
        assert isinstance(make_segmenter(name, trust=trust), CombinedSegmenter)


def test_a_settings_file_that_names_a_combination_lends_it_no_trust(tmp_path: Path) -> None:
    (tmp_path / "c.toml").write_text(f'[segmenter]\nname = "oracle+{OUTSIDE}"\n')
    for arguments, trusted in (((), False), ((f"segmenter.name=oracle+{OUTSIDE}",), True)):
        settings = read_config(tmp_path / "c.toml", arguments, {}).segmenter
        assert settings.trust.covers(OUTSIDE) is trusted


def test_options_of_parts_come_from_the_command_line_and_back_from_a_saved_run(tmp_path: Path) -> None:
    sets = (
        "segmenter.options.near.weights=a.onnx",
        "segmenter.options.near.confidence=0.4",
        "segmenter.options.far.weights=b.onnx",
        "segmenter.options.iou=0.6",
    )
    config = read_config(None, sets, {"segmenter.name": "near=yolo+far=semantic"})
    expected = {"near": {"weights": "a.onnx", "confidence": 0.4}, "far": {"weights": "b.onnx"}, "iou": 0.6}
    assert config.segmenter.options == expected
    file = tmp_path / "config.toml"
    file.write_text(toml_text(list_settings(config)), encoding="utf-8")
    assert read_config(file, (), {}) == config
    changed = read_config(file, ("segmenter.options.near.confidence=0.5",), {}).segmenter.options
    assert changed == expected | {"near": {"weights": "a.onnx", "confidence": 0.5}}


def test_a_detector_over_a_semantic_model(tmp_path: Path) -> None:
    # The detector finds what is red, in one mask for both chairs; of the semantic model's chairs nothing is left.
    yolo = write_export(tmp_path / "y.onnx", dense(8400, [(0, 0, 4000, 4000, 0.75, 41)]))
    semantic = write_semantic(tmp_path / "s.onnx")
    segmenter = make_segmenter("yolo+semantic", {"yolo": {"weights": yolo}, "semantic": {"weights": semantic}})
    masks = pickle.loads(pickle.dumps(segmenter)).segment(picture())
    assert masks.class_names == ("cup", "wall", "floor")
    np.testing.assert_array_equal(masks.is_stuff, [False, True, True])
    assert masks.masks.any(axis=0).mean() > 0.95
    assert masks.masks.sum(axis=0).max() == 1


def frame(index: int) -> Frame:
    return Frame(
        index, 0.0, np.zeros((12, 16, 3), np.uint8), np.ones((12, 16), np.float32), Intrinsics(16, 12, 9, 9, 8, 6)
    )


def test_masks_from_files_combine_and_their_gaps_are_said(tmp_path: Path) -> None:
    ids = np.zeros((1, 12, 16), np.bool_)
    ids[0, 2:6, 2:6] = True
    flags = {"scores": np.array([0.95]), "names": np.array(["wall"]), "stuff": np.array([True])}
    np.savez(tmp_path / "000003.npz", masks=ids, **flags)
    segmenter = CombinedSegmenter({"stored": make_segmenter("masks", {"folder": tmp_path}), "whole": Whole()})
    assert segmenter.segment(frame(3)).class_names == ("box",)  # over all of the stuff
    assert segmenter.segment(frame(4)).class_names == ("box",)
    said = io.StringIO()
    note_stored_masks(segmenter, range(2, 5), Console(file=said, width=400))
    assert "has masks for 1 of 3 frames" in said.getvalue()
    with pytest.raises(BadInput, match="has masks for none of the 2 frames"):
        note_stored_masks(segmenter, range(4, 6), Console(file=said))


def test_stuff_of_masks_on_file_is_checked(tmp_path: Path) -> None:
    np.savez(tmp_path / "000003.npz", masks=np.ones((2, 12, 16), np.bool_), stuff=np.array([0, 2]))
    with pytest.raises(BadInput, match="stuff must say true or false of each"):
        make_segmenter("masks", {"folder": tmp_path}).segment(frame(3))


def test_a_run_maps_a_combination_and_keeps_its_settings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    room = write_small_room(tmp_path / "room", n_frames=4)
    (tmp_path / "stored").mkdir()
    for index in range(4):
        mask = np.zeros((1, 120, 160), np.bool_)
        mask[0, 40:80, 60:100] = True
        np.savez(tmp_path / f"stored/{index:06d}.npz", masks=mask, names=np.array(["crate"]))
    semantic = write_semantic(tmp_path / "s.onnx")
    rng = np.random.default_rng(0)
    for number, names in enumerate((["crate", "cup"], ["wall", "floor", "cup"])):
        np.savez(tmp_path / f"{number}.npz", names=np.array(names), text=rng.normal(size=(len(names), 8)))
    options = {
        "segmenter.options.masks.folder": tmp_path / "stored",
        "segmenter.options.semantic.weights": semantic,
        "embedder.options.table": f"{tmp_path / '0.npz'},{tmp_path / '1.npz'}",
    }
    sets = [text for name, value in options.items() for text in ("--set", f"{name}={value}")]
    models = ("--segmenter", "masks+semantic", "--embedder", "names", *sets)
    code, _, err = razer(capsys, "run", room, "-o", tmp_path / "run", *models, *QUICK, "--no-timeline")
    assert code == 0, err
    assert {"crate", "wall"} <= {entry["class"] for entry in instances_of(tmp_path / "run")}
    kept = read_config(tmp_path / "run/config.toml", (), {}).segmenter
    assert kept.name == "masks+semantic"
    assert kept.options["semantic"] == {"weights": str(semantic)}
    code, out, err = razer(capsys, "query", tmp_path / "run", "a wall", "--json")
    assert code == 0, err
    assert json.loads(out)["hits"]


@pytest.fixture(scope="module")
def kitchen_models(real_data: Path) -> dict[str, dict[str, Path]]:
    folder = real_data.parent / "models"
    weights = {"yolo": folder / "yolo11n-seg-e2e.onnx", "semantic": folder / "mosaic-r3-ade31.onnx"}
    if missing := [file for file in weights.values() if not file.is_file()]:
        pytest.skip(f"no {missing[0]}: the real models are not here")
    return {part: {"weights": file} for part, file in weights.items()}


def test_a_real_kitchen_has_its_things_over_its_stuff(real_data: Path, kitchen_models: dict) -> None:
    masks = make_segmenter("yolo+semantic", kitchen_models).segment(open_sequence(real_data / "redkitchen")[300])
    names = np.array(masks.class_names)
    assert set(names[masks.is_stuff]) == {"wall"}
    assert {"chair", "cup", "dining table", "tv", "book", "cabinet"} <= set(names[~masks.is_stuff])
    assert masks.masks.any(axis=0).mean() > 0.95
    cup, table = (masks.masks[names == name].any(axis=0) for name in ("cup", "dining table"))
    assert not (masks.masks[masks.is_stuff].any(axis=0) & (cup | table)).any()


def test_names_of_both_models_are_known_from_joined_tables(real_data: Path, kitchen_models: dict) -> None:
    folder = real_data / "clip-vit-b32"
    tables = [folder / f"{name}.npz" for name in ("coco", "scannet200", "lvis")]
    embedder = make_embedder("names", {"table": ",".join(map(str, tables))})
    vectors = embedder.embed_texts(["cup", "wall", "floor", "cabinet", "dining table", "painting", "sofa"])
    alone = make_embedder("names", {"table": tables[1]}).embed_texts(["wall"])
    np.testing.assert_array_equal(vectors[1], alone[0])
    assert len(set(embedder.known_names)) == len(embedder.known_names) > 1300


@pytest.mark.full
def test_a_map_of_the_real_kitchen_is_named_nearly_everywhere(real_data: Path, kitchen_models: dict) -> None:
    tables = [str(real_data / "clip-vit-b32" / f"{name}.npz") for name in ("coco", "scannet200", "lvis")]
    segmenter = make_segmenter("yolo+semantic", kitchen_models)
    mapper = Mapper(MapperConfig(), segmenter, make_embedder("names", {"table": tables}))
    frames = open_sequence(real_data / "redkitchen")
    for index in range(0, len(frames), 8):
        mapper.step(frames[index])
    panoptic = mapper.finish()
    names = {item.id: item.class_name for item in panoptic.objects}
    on_surface = [names.get(number) for number in panoptic.mesh.instances.tolist()]
    assert np.mean([name is not None for name in on_surface]) >= 0.9
    share = {name: on_surface.count(name) / len(on_surface) for name in set(names.values())}
    assert share["wall"] > share["cabinet"] > share["floor"] > 0.02
    assert max(share.get("table", 0), share.get("dining table", 0)) > 0.05
    counts = {name: list(names.values()).count(name) for name in ("chair", "cup", "tv", "book")}
    assert 3 <= counts["chair"] <= 7
    assert min(counts.values()) >= 1
