"""Evaluation input: ground truth and prediction of one scene, as plain arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from razer.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class TimedPoses:
    """A trajectory: stamps (N,) in seconds, strictly increasing, with world_from_camera (N, 4, 4) in metres. Frames
    without a pose are left out; n_frames, where known, counts them too. tracked: of estimated poses, the share of the
    frames asked for that have one, nan where that is not known; None: all frames of the other trajectory were asked
    for. Raises ValueError for other shapes."""

    stamps: FloatArray
    world_from_camera: FloatArray
    n_frames: int | None = None
    tracked: float | None = None

    def __post_init__(self) -> None:
        if self.world_from_camera.shape != (len(self.stamps), 4, 4):
            raise ValueError(
                f"{len(self.stamps)} stamps and poses {self.world_from_camera.shape}: one 4x4 each is needed"
            )
        if (np.diff(self.stamps) <= 0).any():
            raise ValueError("the stamps of a trajectory must increase")


@dataclass(frozen=True, slots=True)
class TruthScene:
    """The truth on V vertices: vertices (V, 3) metres, instances (V,) with 0 for none, classes (V,) with 0 for
    unlabelled and class_names naming the others, evaluated (V,) the vertices that count (None = all; what no frame
    observed should not count), triangles (T, 3) of vertex numbers, the trajectory, and relations (instance, relation,
    instance), None where they are not known."""

    vertices: FloatArray
    instances: IntArray
    classes: IntArray
    class_names: Mapping[int, str]
    triangles: IntArray | None = None
    evaluated: BoolArray | None = None
    trajectory: TimedPoses | None = None
    relations: Sequence[tuple[int, str, int]] | None = None

    def __post_init__(self) -> None:
        _check_points(self.vertices, "truth")
        counts = {len(self.vertices), len(self.instances), len(self.classes)}
        if len(counts) > 1 or (self.evaluated is not None and len(self.evaluated) != len(self.vertices)):
            raise ValueError("a truth needs one instance, class and `evaluated` for each vertex")

    @property
    def counts(self) -> BoolArray:
        """Which vertices (V,) count."""
        return np.ones(len(self.vertices), np.bool_) if self.evaluated is None else self.evaluated


@dataclass(frozen=True, slots=True)
class PredictedScene:
    """A prediction, in one of three forms:

    a surface of its own: vertices (P, 3) metres, instances (P,), perhaps triangles (T, 3) and classes (P,);
    labels on the truth's vertices: vertices None, instances (V,) and/or classes (V,);
    masks on the truth's vertices: masks, instance id -> vertex numbers (M,) or truth values (V,), which may overlap.

    Instance ids are >= 1, 0 is none. scores: of the ids (1 where missing). class_names: of the ids, empty for none;
    name_probabilities, where they are known.
    classes: semantic classes per vertex, 0 for none, named by vertex_class_names; where None, each vertex has the class
    of its instance. names_of_truth: class names given to the truth's own masks, by true instance id (retrieval i).
    own_frame: whether the surface lies in the frame of the estimated trajectory, so that it has to be moved first, by
    the alignment of the trajectories by full poses. views_of_truth: in how many of some poses (N, 4, 4) in the truth's
    frame each true instance is shown, by id. relations: (instance, relation, instance), None where none were made out.
    Predictions of equal score are taken in the order of their ids."""

    vertices: FloatArray | None = None
    instances: IntArray | None = None
    triangles: IntArray | None = None
    masks: Mapping[int, IntArray | BoolArray] | None = None
    scores: Mapping[int, float] = field(default_factory=dict)
    class_names: Mapping[int, str] = field(default_factory=dict)
    classes: IntArray | None = None
    vertex_class_names: Mapping[int, str] = field(default_factory=dict)
    names_of_truth: Mapping[int, str] | None = None
    trajectory: TimedPoses | None = None
    own_frame: bool = False
    views_of_truth: Callable[[FloatArray], Mapping[int, int]] | None = None
    relations: Sequence[tuple[int, str, int]] | None = None
    name_probabilities: Mapping[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        labels = [part for part in (self.instances, self.classes) if part is not None]
        if self.vertices is not None:
            _check_points(self.vertices, "predicted")
            if any(len(part) != len(self.vertices) for part in labels) or self.masks is not None:
                raise ValueError("a predicted surface needs one instance and class for each of its vertices, no masks")
        elif self.masks is not None and self.instances is not None:
            raise ValueError("a prediction has masks or one instance for each vertex, not both")


def _check_points(vertices: FloatArray, whose: str) -> None:
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError(f"{whose} vertices have the shape {vertices.shape}, not (V, 3)")
    if not np.isfinite(vertices).all():
        raise ValueError(f"{whose} vertices must be finite")
