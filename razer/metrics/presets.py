"""The rules of an evaluation, every one an option, and the rules that published numbers follow (protocols A to D)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from razer.config import Settings
from razer.metrics.instance_ap import AP_THRESHOLDS

OverScenes = Literal["pooled", "mean"]


class Preset(Settings):
    """A complete set of rules; `model_dump()` prints them."""

    name: str = Field(description="What the rules are called in tables.")
    source: str = Field("", description="Where the rules come from.")
    vocabulary: str = Field(
        "truth",
        description="List that names are looked up in (razer.vocabulary); 'truth': the names the truth itself bears.",
    )

    transfer_k: int = Field(
        1, ge=1, le=50, description="A truth vertex takes the label of most of this many nearest predicted vertices."
    )
    transfer_max_m: float | None = Field(
        0.05, gt=0, description="Predicted vertices farther than this do not count, metres; none: no limit."
    )

    instance_classes: tuple[str, ...] = Field(
        (), description="Classes whose instances are evaluated; empty: all of the vocabulary, or of the truth."
    )
    instance_ignored: tuple[str, ...] = Field(
        ("wall", "floor"), description="Classes whose instances are not evaluated: their vertices are void."
    )
    class_lists: dict[str, tuple[str, ...]] = Field(
        {}, description="Further lists of instance classes that are reported beside the first one."
    )
    thresholds: tuple[float, ...] = Field(
        AP_THRESHOLDS, description="Intersections over union whose precisions are averaged to AP."
    )
    strict: bool = Field(
        True, description="Whether the intersection over union must exceed the threshold, or reach it."
    )
    min_region: int = Field(
        100, ge=1, description="Vertices of the smallest truth looked for and of the smallest prediction that exists."
    )
    score: Literal["own", "one", "size_share"] = Field(
        "own",
        description="Confidence of a prediction: its own, 1 for all, or its vertices / those of the largest prediction "
        "of its class in the scene.",
    )
    optimistic: bool = Field(
        False, description="Matched predictions get confidence 1: flatters, since no system knows what will match."
    )
    instance_class: Literal["own", "vertices"] = Field(
        "own", description="Class of a predicted instance: its own, or the most frequent one of its vertices."
    )
    instances_over_scenes: OverScenes = Field(
        "pooled", description="AP of the predictions of all scenes in one ranking, or mean of the scenes' APs."
    )

    panoptic_min_region: int = Field(1, ge=1, description="Vertices of the smallest segment in panoptic quality.")

    semantic_classes: tuple[str, ...] = Field(
        (), description="Classes that semantic segmentation looks at; empty: all of the vocabulary, or of the truth."
    )
    semantic_ignored: tuple[str, ...] = Field((), description="Classes left out of semantic segmentation, by name.")
    semantic_ignored_parts: tuple[str, ...] = Field(
        (), description="Classes whose name has one of these words in it are left out of semantic segmentation."
    )
    semantics_over_scenes: OverScenes = Field(
        "pooled", description="Numbers of the confusion of all scenes, or mean of the scenes' numbers."
    )

    retrieval_min_iou: float = Field(0.25, ge=0, lt=1, description="A true and a predicted mask must overlap by more.")

    text_template: str = Field(
        "a {} in a scene", description="Sentence a class name is put into before it is embedded."
    )
    voxel_size_m: float | None = Field(None, description="Voxel size such maps are made with, metres.")
    depth_max_m: float | None = Field(None, description="Depth range such maps are made with, metres.")
    truncation_voxels: float | None = Field(None, description="Truncation such maps are made with, voxels.")
    every: int = Field(1, ge=1, description="Such maps are made of every so manieth frame.")
    scenes: tuple[str, ...] = Field((), description="Scenes of the published table.")
    worst: int = Field(20, ge=0, description="How many of the worst instances are listed.")


PRESETS: dict[str, Preset] = {
    name: Preset(name=name)
    for name in (
        "default",
        "scannet200",
        "scenenn",
        "hovsg",
        "conceptgraphs",
        "ovo",
        "rayfronts",
        "ovi-map",
        "retrieval",
    )
}
