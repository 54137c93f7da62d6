"""The picture of a map: cropped to it, antialiased, shaded, seen from where most is shown, with the names of the
largest things."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from app.pictures.camera import PictureCamera, fitted_camera
from app.pictures.front_faces import FrontFaces
from app.pictures.label_drawing import Color, LabelPen
from app.pictures.label_layout import place_labels
from app.pictures.shading import lit, openness
from app.pictures.style_colors import VertexColors, as_bytes
from app.pictures.view import LARGEST, Angle, Background, View
from app.pictures.view_angle import best_angle, camera_axes, wall_heading
from razer.arrays import BoolArray, Float32Array, Float64Array, Int32Array, Uint8Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.normals import vertex_normals

_SAMPLES = 2  # along each side of a pixel
_STRIP_ROWS = 640
_MARGIN = 0.045  # of the picture's mean side, on each side of the map
_BARE = -1


@dataclass(frozen=True)
class Scene:
    """What a picture shows: a mesh with the colours of its vertices, up (3,); names by instance, the most important
    first; wanted: the instances that the angle is chosen for; left_out (V,): vertices that are not drawn; legend: what
    colours mean."""

    mesh: LabelledMesh
    colors: VertexColors
    up: Float64Array
    names: Mapping[int, str] = field(default_factory=dict)
    wanted: Sequence[int] = ()
    left_out: BoolArray | None = None
    legend: Sequence[tuple[str, Color]] = ()


@dataclass(frozen=True)
class Picture:
    """pixels (H, W, 3), RGB, or (H, W, 4) with opacity, uint8; angle: from where it shows the map; labelled: the
    instances whose names are in it."""

    pixels: Uint8Array
    angle: Angle
    labelled: tuple[int, ...]


@dataclass(frozen=True)
class Rendering:
    """color (H, W, 3) from 0 to 255, opacity (H, W) from 0 to 1, and of each pixel the instance (H, W), -1 = bare
    ground."""

    color: Float32Array
    opacity: Float32Array
    instances: Int32Array

    def on(self, background: Background) -> Uint8Array:
        """The pixels (H, W, 3) on white, or (H, W, 4) on nothing."""
        alpha = self.opacity[..., None]
        if background == "white":
            return as_bytes(self.color * alpha + 255 * (1 - alpha))
        return np.dstack([as_bytes(self.color), as_bytes(255 * self.opacity)])


def draw(scene: Scene, view: View | None = None) -> Picture:
    """Draw a scene; that of an empty map is bare ground."""
    view = view or View()
    size = view.size or LARGEST
    if not len(scene.mesh.triangles):
        ground = np.zeros((size[1], size[0]), np.float32)
        empty = Rendering(np.zeros((*ground.shape, 3), np.float32), ground, np.full(ground.shape, _BARE, np.int32))
        return Picture(empty.on(view.background), view.angle or Angle(0.0, 90.0), ())
    up = scene.up / np.linalg.norm(scene.up)
    front = wall_heading(scene.mesh, up)
    angle = view.angle or best_angle(scene.mesh, up, front, scene.wanted, scene.left_out)
    axes = camera_axes(up, front, angle)
    margin = round(_MARGIN * sum(size) / 2)
    camera = fitted_camera(axes, _drawn(scene), size, margin, crops=view.size is None)
    rendering = render(scene, camera)
    image = np.ascontiguousarray(rendering.on(view.background))
    pen = LabelPen(camera.size)
    legend = pen.draw_legend(image, scene.legend)
    labels = place_labels(rendering.instances, _seen_only(scene.names, rendering.instances), pen.size_of, legend)
    pen.draw(image, labels, _mean_colors(scene, [label.instance for label in labels]))
    return Picture(image, angle, tuple(label.instance for label in labels))


def render(scene: Scene, camera: PictureCamera) -> Rendering:
    """Render a scene without names: rays through several places of each pixel, light, ambient occlusion."""
    width, height = camera.size
    up = scene.up / np.linalg.norm(scene.up)
    faces = FrontFaces(scene.mesh, camera.scaled(_SAMPLES), scene.left_out)
    light = lit(vertex_normals(scene.mesh), camera.axes, up)
    color, opacity = np.zeros((height, width, 3), np.float32), np.zeros((height, width), np.float32)
    instances = np.full((height, width), _BARE, np.int32)
    distance = np.full((height, width), np.inf, np.float32)
    for first in range(0, height, _STRIP_ROWS):
        rows = slice(first, min(first + _STRIP_ROWS, height))
        hits = faces.seen(_SAMPLES * rows.start, _SAMPLES * rows.stop)
        values, labels = np.zeros((*hits.covered.shape, 3), np.float32), np.full(hits.covered.shape, _BARE, np.int32)
        colors = scene.colors.values
        own = hits.blended(colors) if scene.colors.blends else colors[hits.nearest]
        values[hits.covered] = own * hits.blended(light)[:, None]
        labels[hits.covered] = scene.mesh.instances[hits.nearest]
        color[rows], opacity[rows] = _shrunk(values), _shrunk(hits.covered.astype(np.float32))
        distance[rows], instances[rows] = hits.distance[::_SAMPLES, ::_SAMPLES], labels[::_SAMPLES, ::_SAMPLES]
    color *= (openness(distance, camera) / np.maximum(opacity, 1e-3))[..., None]
    return Rendering(color, opacity, instances)


def _shrunk(values: Float32Array) -> Float32Array:
    shape = values.shape[1] // _SAMPLES, values.shape[0] // _SAMPLES
    smaller: Float32Array = cv2.resize(values, shape, interpolation=cv2.INTER_AREA)
    return smaller


def _drawn(scene: Scene) -> Float32Array:
    """The vertices (N, 3) of triangles that are drawn."""
    triangles = scene.mesh.triangles
    if scene.left_out is not None:
        kept = triangles[~scene.left_out[triangles].any(axis=1)]
        triangles = kept if len(kept) else triangles
    is_drawn = np.zeros(len(scene.mesh.vertices), np.bool_)
    is_drawn[triangles] = True
    return scene.mesh.vertices[is_drawn]


def _seen_only(names: Mapping[int, str], instances: Int32Array) -> dict[int, str]:
    """Names of what is seen, in their order."""
    counts = np.bincount(instances.clip(min=0).ravel(), minlength=max(names, default=0) + 1)
    return {number: text for number, text in names.items() if counts[number]}


def _mean_colors(scene: Scene, numbers: Sequence[int]) -> dict[int, Color]:
    """The mean colour of each instance in the picture."""
    found = {}
    for number in numbers:
        red, green, blue = scene.colors.values[scene.mesh.instances == number].mean(axis=0).round().astype(int).tolist()
        found[number] = (min(red, 255), min(green, 255), min(blue, 255))
    return found
