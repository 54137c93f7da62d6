"""Ground truth of a scene: its surface as labelled points, and which of them a recording could see."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.arrays import BoolArray, FloatArray, Int32Array, Uint8Array


@dataclass(frozen=True, slots=True)
class GroundTruth:
    """A labelled surface: vertices (V, 3) in metres, float32, or float64 where they lie far from zero, triangles (T, 3)
    int32, instances (V,) int32 with 0 = nobody's, classes (V,) int32 with class_names naming them and 0 = unlabelled,
    visible (V,) bool: seen often enough to count; notes say in words what a reader could not make out;
    rgbd_calibration, where the recording's declared camera is not that of its colour, which one is; vocabulary: the
    list whose numbers the classes have, empty where they are numbered by the truth itself; colors (V, 3) uint8 where
    the surface has any; relations: (instance, relation, instance), such as what is "on" what; None where the truth does
    not state them."""

    vertices: FloatArray
    triangles: Int32Array
    instances: Int32Array
    classes: Int32Array
    class_names: Mapping[int, str]
    visible: BoolArray
    notes: tuple[str, ...] = ()
    rgbd_calibration: RgbdCalibration | None = None
    vocabulary: str = ""
    colors: Uint8Array | None = None
    relations: tuple[tuple[int, str, int], ...] | None = None

    def __post_init__(self) -> None:
        count = len(self.vertices)
        if not count == len(self.instances) == len(self.classes) == len(self.visible):
            raise ValueError("a ground truth needs one instance, class and visibility for each vertex")

    @property
    def instance_classes(self) -> dict[int, str]:
        """The class name of each instance id; those of class 0 have none."""
        ids, first = np.unique(self.instances, return_index=True)
        pairs = zip(ids.tolist(), self.classes[first].tolist(), strict=True)
        return {i: self.class_names[c] for i, c in pairs if i > 0 and c > 0}
