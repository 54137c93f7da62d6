"""Evaluation presets: the rules that published numbers follow (docs/evaluation.md, "Presets"; protocols A to D)."""

from __future__ import annotations

from razer.metrics.preset import Preset
from razer.vocabulary import vocabulary

__all__ = ["PRESETS", "Preset"]

_NOT_THINGS = ("wall", "floor")
_REPLICA_SCENES = tuple([f"office{i}" for i in range(5)] + [f"room{i}" for i in range(3)])
_HOVSG_SCANNET = ("scene0011_00", "scene0050_00", "scene0231_00", "scene0378_00", "scene0518_00")
_SCENENN_SCENES = ("011", "016", "030", "061", "078", "086", "096", "206", "223", "255")
_RETRIEVAL_NYU40 = (*range(3, 13), 14, 16, 24, 28, 33, 34, 36)
# The classes of Replica that occur in its eight rooms, by the dataset's own spelling.
_REPLICA_51 = (
    "basket bed bench bin blanket blinds book bottle box bowl camera cabinet candle chair clock cloth comforter cushion"
    " ceiling desk desk-organizer door floor indoor-plant lamp monitor nightstand panel picture pillar pillow pipe"
    " plant-stand plate pot sculpture shelf sofa stool switch table tablet tissue-paper tv-screen tv-stand vase vent"
    " wall wall-plug window rug"
)


def _nyu40_names(ids: tuple[int, ...]) -> tuple[str, ...]:
    return tuple(vocabulary("nyu40").by_id[i].name for i in ids)


_SCANNET200 = Preset(
    name="scannet200",
    source="ScanNet benchmark script with the ScanNet200 classes (protocol B)",
    vocabulary="scannet200",
    instance_ignored=_NOT_THINGS,
)

_SCANNET20 = Preset(
    name="scannet20",
    source="ScanNet benchmark script with its 18 classes, numbered as NYU40 (protocol B)",
    vocabulary="scannet20",
    instance_ignored=_NOT_THINGS,
    stuff=_NOT_THINGS,
)

_SCENENN = Preset(
    name="scenenn",
    source="VolumePanoptic on SceneNN, NYU classes (protocol A)",
    vocabulary="nyu40",
    instance_classes=tuple(name for name in vocabulary("scannet20").names if name not in _NOT_THINGS),
    class_lists={"nine": ("bed", "chair", "sofa", "table", "refridgerator", "television", "bag", "books", "toilet")},
    score="size_share",
    instance_class="vertices",
    instances_over_scenes="mean",
    semantics_over_scenes="mean",
    voxel_size_m=0.01,
    truncation_voxels=5,
    depth_max_m=3,
    scenes=_SCENENN_SCENES,
)

_HOVSG = Preset(
    name="hovsg",
    source="HOV-SG on Replica and ScanNet (protocol C)",
    semantic_k=5,
    semantic_max_m=None,
    semantic_ignored_parts=("wall", "floor", "ceiling", "door", "window", "background"),
    semantics_over_scenes="mean",
    voxel_size_m=0.02,
    every=10,
    scenes=(*_REPLICA_SCENES, *_HOVSG_SCANNET),
)

_CONCEPTGRAPHS_1 = ("other",)
_CONCEPTGRAPHS_4 = (*_CONCEPTGRAPHS_1, "floor", "wall", "ceiling")

_CONCEPTGRAPHS = Preset(
    name="conceptgraphs",
    source="ConceptGraphs on Replica (protocol C)",
    semantic_max_m=None,
    unlabelled_vote=False,
    semantic_ignored=(*_CONCEPTGRAPHS_4, "door", "window"),
    semantic_lists={"without 1": _CONCEPTGRAPHS_1, "without 4": _CONCEPTGRAPHS_4},
    count_ignored_points=False,
    name_among="scene",
    voxel_size_m=0.02,
    every=10,
    scenes=_REPLICA_SCENES,
)

_OVO = _HOVSG.model_copy(
    update={
        "name": "ovo",
        "source": "OVO on Replica (protocol C)",
        "semantic_classes": tuple(_REPLICA_51.split()),
        "semantic_ignored_parts": (),
        "semantics_over_scenes": "pooled",
        "scenes": _REPLICA_SCENES,
    }
)

_RAYFRONTS = _HOVSG.model_copy(update={"name": "rayfronts", "source": "RayFronts (protocol C)", "voxel_size_m": 0.05})

_OVI_MAP = _HOVSG.model_copy(
    update={
        "name": "ovi-map",
        "source": "OVI-MAP (protocol C)",
        "semantic_k": 1,
        "semantic_max_m": 0.05,
        "semantics_over_scenes": "pooled",
    }
)

_RETRIEVAL = Preset(
    name="retrieval",
    source="OpenIns3D on ScanNetv2, top-1 of 17 classes (protocol D)",
    vocabulary="nyu40",
    instance_classes=_nyu40_names(_RETRIEVAL_NYU40),
    retrieval_classes=_nyu40_names(_RETRIEVAL_NYU40),
)

_DEFAULT = Preset(
    source="Instances and semantics by the truth's own names, without walls, floors and ceilings as things"
)

PRESETS: dict[str, Preset] = {
    preset.name: preset
    for preset in (
        _DEFAULT.model_copy(update={"instance_ignored": (*_NOT_THINGS, "ceiling")}),
        _SCANNET200,
        _SCANNET20,
        _SCENENN,
        _HOVSG,
        _CONCEPTGRAPHS,
        _OVO,
        _RAYFRONTS,
        _OVI_MAP,
        _RETRIEVAL,
    )
}
