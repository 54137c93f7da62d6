"""Ground truth of SceneNN: 005.ply with a label on each vertex, and 005.xml with the object of each label.

In the xml, <label id="2" text="chair" nyu_class="chair" .../> names an object freely in text and by a class of
NYU40 in nyu_class, with a few names of its own; label 0 is nobody's. Source: https://github.com/hkust-vgd/scenenn
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.ply import read_ply
from data_tools.truth.vertex_colors import vertex_colors
from razer.errors import BadInput
from razer.files import MALFORMED, read_text
from razer.vocabulary import Category, Vocabulary, vocabulary

# What the xml files write for some classes of NYU40, as published training code maps them.
_MAX_XML_BYTES = 2**24
_NYU40_BY_SCENENN = {
    "prop": "otherprop",
    "furniture": "otherfurniture",
    "structure": "otherstructure",
    "fridge": "refridgerator",
    "refrigerator": "refridgerator",
    "tv": "television",
}


@dataclass(frozen=True, slots=True)
class Label:
    """What the xml says of one label: a free name, and a name of NYU40 or empty."""

    text: str
    nyu40: str


def is_scenenn_truth(folder: Path) -> bool:
    """Whether there is a mesh with an xml of the same name."""
    return _scene(folder) is not None


def read_scenenn_truth(folder: Path, vocabulary_name: str = "nyu40") -> GroundTruth:
    """The labelled mesh of a scene; raises BadInput. Classes are those of the vocabulary that carry an object's NYU40
    name or its free name, or else the only ones with its NYU40 number; where there is none the class is 0."""
    if (scene := _scene(folder)) is None:
        raise BadInput(f"{folder} has no mesh with an .xml of the same name, as SceneNN's ground truth has")
    return read_scenenn_mesh(scene, vocabulary_name)


def read_scenenn_mesh(scene: Path, vocabulary_name: str = "nyu40") -> GroundTruth:
    """The labelled mesh in one file, with its xml beside it, as read_scenenn_truth reads that of a folder."""
    mesh = read_ply(scene)
    labels = read_labels(scene.with_suffix(".xml"))
    of_vertex = mesh.column("label", scene).astype(np.int64)
    classes = vocabulary(vocabulary_name)
    category_of = {number: _category(label, classes) for number, label in labels.items()}
    known, where = np.unique(of_vertex, return_inverse=True)
    instances = np.array([i if i in labels else 0 for i in known.tolist()], np.int32)
    numbers = np.array([category.id if (category := category_of.get(i)) else 0 for i in known.tolist()], np.int32)
    names = {category.id: category.name for category in category_of.values() if category}
    visible = np.ones(len(of_vertex), np.bool_)
    points, colors = mesh.points(scene), vertex_colors(mesh)
    labels_of = instances[where], numbers[where]
    return GroundTruth(points, mesh.triangles, *labels_of, names, visible, vocabulary=vocabulary_name, colors=colors)


def read_labels(path: Path) -> Mapping[int, Label]:
    """What an xml says of each label above 0; raises BadInput naming the file."""
    try:
        items = ElementTree.fromstring(read_text(path, max_bytes=_MAX_XML_BYTES)).iter("label")
        return {
            number: Label(item.get("text", "").strip().lower(), _nyu40_name(item.get("nyu_class", "")))
            for item in items
            if (number := int(item.get("id", "0"))) > 0
        }
    except ElementTree.ParseError as error:
        raise BadInput(f"{path} is no XML: {error}") from None
    except MALFORMED as error:
        raise BadInput(f'{path} must be XML with <label id="1" nyu_class="chair"/> (problem: {error})') from None


def _scene(folder: Path) -> Path | None:
    meshes = (path for path in sorted(folder.glob("*.ply")) if path.with_suffix(".xml").is_file())
    return next(meshes, None)


def _nyu40_name(name: str) -> str:
    plain = name.strip().lower().replace("_", " ")
    return _NYU40_BY_SCENENN.get(plain, plain)


def _category(label: Label, classes: Vocabulary) -> Category | None:
    for name in (label.nyu40, label.text) if classes.name == "nyu40" else (label.text, label.nyu40):
        if name in classes.by_name:
            return classes.by_name[name]
    nyu40 = vocabulary("nyu40").by_name.get(label.nyu40)
    same = [category for category in classes.categories if nyu40 and category.nyu40 == nyu40.id]
    return same[0] if len(same) == 1 else None
