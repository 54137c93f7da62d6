"""Evaluation settings: every rule of a protocol is an option; razer.metrics.presets holds those of the papers."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from razer.metrics.class_table import FROM_TRUTH
from razer.metrics.instances.instance_ap import AP_THRESHOLDS, ApSettings
from razer.settings import Settings

OverScenes = Literal["pooled", "mean"]


class Preset(Settings):
    """A complete set of rules; `model_dump()` prints them, `model_copy(update=...)` changes them."""

    name: str = Field("default", description="What the rules are called in tables.")
    source: str = Field("", description="Where the rules come from.")
    vocabulary: str = Field(FROM_TRUTH, description="Label set of all names; 'truth': the names of the truth itself.")

    # From the predicted surface to the truth's vertices.
    instance_k: int = Field(
        1, ge=1, le=50, description="A truth vertex takes the instance of most of this many nearest predicted vertices."
    )
    instance_max_m: float | None = Field(
        0.05, gt=0, description="Predicted vertices farther than this carry no instance, metres; none: no limit."
    )
    semantic_k: int = Field(
        1, ge=1, le=50, description="A truth vertex takes the class of most of this many nearest predicted vertices."
    )
    semantic_max_m: float | None = Field(
        0.05, gt=0, description="Predicted vertices farther than this carry no class, metres; none: no limit."
    )
    unlabelled_vote: bool = Field(
        True,
        description="Whether predicted vertices without a class take part, so that truth near them stays without one, "
        "or are left out of the surface, so that it takes the class of what lies next.",
    )

    # Instances.
    instance_classes: tuple[str, ...] = Field(
        (), description="Classes whose instances are evaluated; empty: all of the vocabulary."
    )
    instance_ignored: tuple[str, ...] = Field(
        ("wall", "floor"), description="Classes whose instances are not evaluated: their vertices are void."
    )
    class_lists: dict[str, tuple[str, ...]] = Field(
        {}, description="Further lists of instance classes that are reported beside the first one."
    )
    thresholds: tuple[float, ...] = Field(
        AP_THRESHOLDS, min_length=1, description="Intersections over union whose precisions are averaged to AP."
    )
    strict: bool = Field(True, description="Whether the intersection over union must exceed a threshold, or reach it.")
    min_region: int = Field(
        100, ge=1, description="Vertices of the smallest truth and of the smallest prediction that are evaluated."
    )
    score: Literal["own", "one", "size_share"] = Field(
        "own",
        description="Confidence of a prediction: its own, 1 for all, or its vertices / those of the largest prediction "
        "of its class in the scene.",
    )
    optimistic: bool = Field(
        False,
        description="Matched predictions get confidence 1: biased upwards, since no system knows what will match.",
    )
    instance_class: Literal["own", "vertices"] = Field(
        "own",
        description="Class of a predicted instance: its own (where it has none, as with 'vertices'), or the most "
        "frequent one of its vertices, where the prediction gives these classes of their own.",
    )
    instances_over_scenes: OverScenes = Field(
        "pooled", description="AP of the predictions of all scenes in one ranking, or mean of the scenes' APs."
    )

    # Panoptic quality.
    stuff: tuple[str, ...] = Field(
        ("wall", "floor", "ceiling"), description="Classes with one segment in a scene in panoptic quality."
    )
    panoptic_min_region: int = Field(1, ge=1, description="Vertices of the smallest segment in panoptic quality.")

    # Semantic segmentation.
    semantic_classes: tuple[str, ...] = Field(
        (), description="Classes that semantic segmentation looks at; empty: all of the vocabulary."
    )
    semantic_ignored: tuple[str, ...] = Field((), description="Classes that semantic segmentation leaves out.")
    semantic_ignored_parts: tuple[str, ...] = Field(
        (), description="Substrings: classes with one of them in their name are left out of semantic segmentation, too."
    )
    semantic_lists: dict[str, tuple[str, ...]] = Field(
        {}, description="Further lists of left-out classes whose numbers are reported beside the first ones."
    )
    count_ignored_points: bool = Field(
        True, description="Whether predictions on vertices whose true class is left out count as wrong predictions."
    )
    semantics_over_scenes: OverScenes = Field(
        "pooled", description="Numbers of the confusion of all scenes, or mean of the scenes' numbers."
    )

    # Retrieval.
    retrieval_classes: tuple[str, ...] = Field((), description="Classes of retrieval; empty: those of the instances.")
    retrieval_min_iou: float = Field(0.25, ge=0, lt=1, description="A true and a predicted mask must overlap by more.")
    retrieval_missed: Literal["wrong", "left_out"] = Field(
        "wrong", description="What a true instance counts as that no predicted one overlaps enough."
    )

    # How the published maps were made, for reproducing them; the evaluation itself does not use it.
    text_template: str | None = Field(
        None,
        description="Sentence with {} for a class name, by which instances are named where they are named by text; "
        "none: the prompts of `razer query`, averaged.",
    )
    name_among: Literal["vocabulary", "scene"] = Field(
        "vocabulary", description="Classes a system may choose from: the whole list, or those in the scene's truth."
    )
    voxel_size_m: float | None = Field(None, gt=0, description="Voxel size of such maps, metres.")
    truncation_voxels: float | None = Field(None, gt=0, description="Truncation distance of such maps, voxels.")
    depth_max_m: float | None = Field(None, gt=0, description="Depth range of such maps, metres.")
    every: int = Field(1, ge=1, description="Such maps are made of one frame in so many.")
    scenes: tuple[str, ...] = Field((), description="Scenes of the published table.")

    worst: int = Field(20, ge=0, description="How many of the worst instances are listed.")

    @property
    def ap_settings(self) -> ApSettings:
        """The rules of average precision."""
        return ApSettings(self.thresholds, self.min_region, self.strict, self.optimistic)
