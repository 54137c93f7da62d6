"""Alignment of two maps of one place: by full poses, then refined on their surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from app.run_folder.mapped_run import MappedRun
from razer.arrays import Float64Array
from razer.metrics.surface.surface_registration import Surface, SurfaceRegistration, register_surfaces
from razer.metrics.trajectory_errors import TrajectoryMetrics

MapAlignmentBasis = Literal["none", "identity", "poses", "poses and surfaces"]


@dataclass(frozen=True, slots=True)
class MapAlignment:
    """a_from_b (4, 4) brings map B onto map A; by_poses (4, 4) is what full poses alone say, before the refinement.
    Maps without trajectories lie as they lie (none), those of the same poses too (identity): neither is refined."""

    basis: MapAlignmentBasis
    a_from_b: Float64Array
    by_poses: Float64Array
    refinement: SurfaceRegistration | None = None

    def as_json(self) -> dict[str, Any]:
        """aligned_by, both transforms, and of the refinement whether it was kept, why not, and what it changed."""
        refinement = self.refinement
        return {
            "aligned_by": self.basis,
            "a_from_b": self.a_from_b.tolist(),
            "a_from_b_by_poses": self.by_poses.tolist(),
            "refinement": None
            if refinement is None
            else {
                "kept": refinement.rejected is None,
                "rejected": refinement.rejected,
                "moved_m": refinement.moved_m,
                "moved_deg": refinement.moved_deg,
                "fit_before_m": refinement.fit_before_m,
                "fit_after_m": refinement.fit_after_m,
            },
        }

    def describe(self) -> str:
        """How the maps were aligned, in one plain clause."""
        refinement = self.refinement
        if refinement is None:
            return {"none": "not aligned", "identity": "the same poses"}[self.basis]
        if refinement.rejected is not None:
            return f"full poses; not refined on the surfaces, as {refinement.rejected}"
        assert refinement.fit_before_m is not None
        assert refinement.fit_after_m is not None
        moved = f"{100 * (refinement.moved_m or 0):.1f} cm and {refinement.moved_deg or 0:.2f} degrees"
        fit_mm = f"{1e3 * refinement.fit_before_m:.1f} to {1e3 * refinement.fit_after_m:.1f} mm"
        return f"full poses, refined on the surfaces by {moved}: their mean distance fell from {fit_mm}"


def align_maps(a: MappedRun, b: MappedRun, pose: TrajectoryMetrics | None) -> MapAlignment:
    """Bring run B onto run A; `pose` is B's trajectory against A's, None where either has none."""
    if pose is None:
        return MapAlignment("none", np.eye(4), np.eye(4))
    by_poses = pose.truth_from_estimate
    if pose.by_positions.basis == "identity":
        return MapAlignment("identity", by_poses, by_poses)
    moved = b.moved(by_poses).panoptic.mesh
    refinement = register_surfaces(
        Surface(moved.vertices, moved.triangles), Surface(a.panoptic.mesh.vertices, a.panoptic.mesh.triangles)
    )
    if refinement.rejected is not None:
        return MapAlignment("poses", by_poses, by_poses, refinement)
    return MapAlignment("poses and surfaces", refinement.motion @ by_poses, by_poses, refinement)
