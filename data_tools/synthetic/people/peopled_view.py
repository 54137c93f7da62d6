"""Rendering of people into views of a world that stands still."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import open3d as o3d

from data_tools.synthetic.light.emitters import Light
from data_tools.synthetic.people.walkers import Walker
from data_tools.synthetic.rendering.ray_renderer import RayRenderer
from data_tools.synthetic.rendering.rendering import Rendering
from data_tools.synthetic.rendering.rgbd_renderer import Renderer
from data_tools.synthetic.truth.visibility import Occluder
from razer.arrays import BoolArray, Float64Array
from razer.frame import Intrinsics
from razer.geometry import inverse, transform_points

_PHASES = 12
_NEAR_M = 0.1
_BODY = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.7, 0.7) for z in (0.0, 1.0, 2.0)])


class FilmedWalker:
    """Somebody and their renderers, one for each of a few points of the stride, made when first seen."""

    def __init__(self, walker: Walker, camera: Intrinsics, seed: int, light: Light) -> None:
        self._walker, self._camera, self._seed, self._light = walker, camera, seed, light
        self._renderers: dict[int, RayRenderer] = {}

    def at(self, time_s: float) -> tuple[Float64Array, RayRenderer]:
        """Where they are, world_from_person (4, 4), and the renderer of how they stand."""
        world_from_person, phase = self._walker.at(time_s)
        number = int(phase * _PHASES) % _PHASES
        if number not in self._renderers:
            figure = self._walker.figure.walking(number / _PHASES)
            self._renderers[number] = RayRenderer({1: figure}, self._camera, self._seed, self._light)
        return world_from_person, self._renderers[number]


class PeopledView:
    """A world with people as they are at one time; they have no instance id."""

    def __init__(self, still: Renderer, walkers: Sequence[FilmedWalker], time_s: float) -> None:
        self._still = still
        self._people = [walker.at(time_s) for walker in walkers]

    @property
    def scene(self) -> Occluder:
        """What hides one thing behind another, people among it."""
        return _Occluders(self._still.scene, self._people)

    def render(self, world_from_camera: Float64Array) -> Rendering:
        """What the camera at this pose sees."""
        seen = self._still.render(world_from_camera)
        for world_from_person, renderer in self._people:
            person_from_camera = inverse(world_from_person) @ world_from_camera
            if not _may_be_seen(person_from_camera, renderer.intrinsics):
                continue
            person = renderer.render(person_from_camera)
            before = (person.depth > 0) & ((seen.depth == 0) | (person.depth < seen.depth))
            seen.rgb[before], seen.depth[before], seen.ids[before] = person.rgb[before], person.depth[before], 0
            if seen.parts is not None:
                seen.parts[before] = 0
        return seen


def _may_be_seen(person_from_camera: Float64Array, camera: Intrinsics) -> bool:
    """Whether the box round a person may project into the image; never wrongly no."""
    x, y, z = transform_points(inverse(person_from_camera), _BODY).T
    if (z <= _NEAR_M).any():
        return bool((z > 0).any())
    u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
    return bool(u.max() >= 0 and u.min() <= camera.width and v.max() >= 0 and v.min() <= camera.height)


class _Occluders:
    """A world and people in it, as one thing that rays may meet."""

    def __init__(self, still: Occluder, people: Sequence[tuple[Float64Array, RayRenderer]]) -> None:
        self._still, self._people = still, people

    def test_occlusions(self, rays: o3d.core.Tensor, tnear: float = 0.0, tfar: float = np.inf) -> o3d.core.Tensor:
        """Whether each ray (N, 6) meets something between tnear and tfar, in units of its direction."""
        hidden: BoolArray = self._still.test_occlusions(rays, tnear, tfar).numpy().astype(bool)
        lines = rays.numpy()
        for world_from_person, renderer in self._people:
            person_from_world = inverse(world_from_person)
            own = np.empty_like(lines)
            own[:, :3] = transform_points(person_from_world, lines[:, :3])
            own[:, 3:] = lines[:, 3:] @ person_from_world[:3, :3].T
            hidden |= renderer.scene.test_occlusions(o3d.core.Tensor.from_numpy(own), tnear, tfar).numpy().astype(bool)
        return o3d.core.Tensor.from_numpy(hidden)
