"""A labelled mesh as a recording: a hand-held walk through a scan, with poses, instance ids and the truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.camera.walk import FRAMES_PER_S, usual_frames, walk
from data_tools.synthetic.rendered_frames import CAMERA, RenderedFrames
from data_tools.synthetic.rendering.rgbd_renderer import Renderer
from data_tools.synthetic.scans.labelled_mesh import open_labelled_mesh, renumbered, stated_up
from data_tools.synthetic.scans.mesh_renderer import MeshRenderer
from data_tools.synthetic.scans.scan_walk import nearest_m, plan_walk
from data_tools.synthetic.scans.surface import check_mesh
from data_tools.synthetic.scans.upright import upright_from_mesh
from data_tools.synthetic.truth.tessellation import SampledSurface
from data_tools.synthetic.truth.true_surface import MIN_VIEWS
from data_tools.synthetic.truth.visibility import CameraView, Viewpoint, visible_vertices
from data_tools.truth.ground_truth import GroundTruth
from razer.arrays import BoolArray
from razer.errors import BadInput
from razer.geometry import inverse

_LARGEST_ID = 2**16 - 1  # of images of ids


class MeshSequence(RenderedFrames):
    """A walk through a labelled mesh, rendered on demand; poses and truth are in the frame of the mesh.

    Stamps are those of a hand-held camera, however many frames there are.

    Args:
        mesh: a PLY file, or a folder with a truth.
        seed: varies the walk and the hand that holds the camera.
        n_frames: spread evenly over the whole walk; None or 0 = as many as make 15 frames/s.
        width: of the images, pixels.
        height: of the images, pixels.
        sensor: what its images suffer; None = nothing.
        misalignment: how the true colour camera differs from the declared one; None = not at all.
        up: which way is up in the mesh, as upright_from_mesh takes it.
        scale: metres per unit of the mesh.
        report: told what takes long; None = nobody.

    Raises:
        BadInput: for what is no labelled mesh of a place in metres, or has no floor to walk on.
    """

    def __init__(
        self,
        mesh: Path,
        seed: int = 0,
        n_frames: int | None = None,
        width: int = 640,
        height: int = 480,
        *,
        sensor: SensorModel | None = None,
        misalignment: RgbdMisalignment | None = None,
        up: str = "auto",
        scale: float = 1.0,
        report: Callable[[str], None] | None = None,
    ) -> None:
        if n_frames is not None and n_frames < 0:
            raise BadInput(f"a recording of {n_frames} frames is impossible: ask for at least 1")
        sensor = sensor or SensorModel.none()
        truth = renumbered(open_labelled_mesh(mesh, scale), _LARGEST_ID)
        check_mesh(truth, str(mesh))
        if report is not None:
            report(f"planning a walk through {len(truth.triangles)} faces")
        stated = stated_up(mesh) if up == "auto" else None
        plan = plan_walk(truth, upright_from_mesh(truth, ",".join(map(str, stated)) if stated else up), seed)
        self._upright_from_mesh = plan.upright_from_mesh
        usual = usual_frames(plan.stations)
        count = n_frames or usual
        rate = FRAMES_PER_S * max(count - 1, 1) / (usual - 1)
        options: dict[str, Any] = {"sensor": sensor, "misalignment": misalignment, "up": up, "scale": scale}
        super().__init__(
            f"walk-through-{Path(mesh).stem}-{seed}",
            inverse(self._upright_from_mesh) @ walk(plan.stations, count, seed),
            CAMERA.resized(width, height),
            sensor,
            seed,
            partial(MeshSequence, mesh, seed, n_frames, width, height, **options),
            frames_per_s=rate,
            misalignment=misalignment,
            # The shutter stays open as long as at 15 frames/s, however far apart the frames are.
            earlier=inverse(self._upright_from_mesh) @ walk(plan.stations, count, seed, earlier_s=1 / FRAMES_PER_S),
        )
        self._mesh, self._truth, self._plan, self._classes = mesh, truth, plan, truth.instance_classes
        self._up: list[float] = self._upright_from_mesh[2, :3].tolist()
        self._renderer = self._seen_by(lambda camera: MeshRenderer(plan.surface, camera, self._upright_from_mesh))

    @property
    def classes(self) -> Mapping[int, str]:
        """The class name of each instance id."""
        return self._classes

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader of the mesh could not make out, which way was taken for up, and where the walk leads."""
        up = f"up is {self._up[0]:.2f}, {self._up[1]:.2f}, {self._up[2]:.2f} in the mesh (--up says otherwise)"
        return (*self._truth.notes, up, f"the walk leads {self._plan.ground}")

    @property
    def summary(self) -> Mapping[str, Any]:
        """The mesh, which way is up in it, and how near the camera comes to anything, metres."""
        near = round(nearest_m(self._plan.surface, self._upright_from_mesh @ self._poses), 3)
        return {"mesh": str(self._mesh), "up": [round(x, 6) for x in self._up], "nearest_m": near, **super().summary}

    def truth(self, spacing_m: float = 0.01, range_m: tuple[float, float] = (0.1, 5.0)) -> GroundTruth:
        """The mesh itself, whatever spacing_m; visible = seen within range_m (metres along the optical axis) in at
        least 3 frames."""
        return replace(self._truth, visible=self._visible(range_m), rgbd_calibration=self.calibration)

    def _renderer_at(self, index: int) -> Renderer:
        return self._renderer

    def _visible(self, range_m: tuple[float, float]) -> BoolArray:
        surface, normals = self._plan.surface, self._plan.surface.vertex_normals
        viewpoints = [Viewpoint(self._upright_from_mesh @ pose, surface.scene) for pose in self._poses]
        since = np.zeros(len(surface.vertices), np.int64)
        visible = np.zeros(len(since), np.bool_)
        for side in (1, -1) if surface.two_sided else (1,):
            sampled = SampledSurface(
                surface.vertices.astype(np.float64), side * normals, surface.instances, surface.triangles
            )
            visible |= visible_vertices(sampled, viewpoints, CameraView(self.intrinsics, range_m), MIN_VIEWS, since)
        return visible
