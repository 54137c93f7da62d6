"""Files beside a model's weights, tables of names, uploads, and a map to be drawn: how they are made and
read, and whether they are files that a message can name."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from app.pictures.map_picture import draw
from app.pictures.scenes import map_scene
from app.pictures.view import View
from app.served_map.query_picture import decoded_picture
from razer.models.clip.image_input import ImageInput
from razer.models.clip.tokenizer import ClipTokens
from razer.models.name_vectors.name_table import NameVectorTable
from razer.models.semantic.class_names import names_of
from razer.saved_map import load_map

_RUN = Path(__file__).resolve().parent.parent / "fixtures" / "run_format_1"
_VOCABULARY = {"<|startoftext|>": 0, "<|endoftext|>": 1, "a</w>": 2, "c</w>": 3, "a": 4, "c": 5}


def _write_sidecars(folder: Path) -> None:
    from tokenizers import Tokenizer, models

    folder.mkdir()
    (folder / "model.onnx").write_bytes(b"weights")
    texts = {"text_config": {"max_position_embeddings": 8}, "id2label": {"0": "wall", "1": "chair"}}
    (folder / "config.json").write_text(json.dumps(texts))
    (folder / "tokenizer_config.json").write_text('{"model_max_length": 8, "pad_token": "<|endoftext|>"}')
    picture = {"size": {"shortest_edge": 224}, "image_mean": [0.5, 0.5, 0.5], "image_std": [0.2, 0.2, 0.2]}
    (folder / "preprocessor_config.json").write_text(json.dumps(picture))
    Tokenizer(models.BPE(_VOCABULARY, [])).save(str(folder / "tokenizer.json"))


def _read_sidecars(folder: Path) -> None:
    weights = folder / "model.onnx"
    names_of(weights, {}, None)
    ImageInput.beside(weights)
    ClipTokens(weights, None)(["a c"])


def _write_table(folder: Path) -> None:
    folder.mkdir()
    names, synonyms = np.array(["chair", "table"]), np.array(["seat", "desk|board"])
    np.savez_compressed(folder / "names.npz", names=names, synonyms=synonyms, text=np.eye(2, 4, dtype=np.float32))


def _read_table(folder: Path) -> None:
    table = NameVectorTable(folder / "names.npz")
    table.embed_texts(table.names)
    table.embed_class("lamp")


def write_pictures(folder: Path) -> None:
    folder.mkdir()
    noise = np.random.default_rng(0).integers(0, 255, (24, 32, 3), dtype=np.uint8)
    for name in ("a.png", "b.jpg"):
        (folder / name).write_bytes(cv2.imencode(name[1:], noise)[1].tobytes())


def _read_uploads(folder: Path) -> None:
    for path in sorted(folder.iterdir()):
        decoded_picture(path.read_bytes())


def _draw_map(folder: Path) -> None:
    draw(map_scene(load_map(folder), "instance"), View(size=(64, 48)))


_Made = tuple[Callable[[Path], object], Callable[[Path], object], tuple[str, ...], bool]
MODEL_FILES: dict[str, _Made] = {
    "sidecars": (_write_sidecars, _read_sidecars, ("*.json",), False),
    "name table": (_write_table, _read_table, ("*.npz",), False),
    "uploads": (write_pictures, _read_uploads, ("*",), True),
    "drawn map": (lambda f: shutil.copytree(_RUN, f), _draw_map, ("*.json", "mesh.ply"), False),
}
