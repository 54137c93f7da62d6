"""Light map: an image of how brightly each face of a world is lit, made once and looked up for each pixel."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import blake2b
from itertools import product

import numpy as np
import open3d as o3d

from data_tools.synthetic.light.emitters import LIGHTING, Light, ceiling_glow
from data_tools.synthetic.light.face_grid import FaceGrid
from data_tools.synthetic.light.radiosity import Surroundings, gathered, irradiance
from data_tools.synthetic.light.smooth_shading import smoothed_over_edges
from data_tools.synthetic.shapes.solids import quad_normals
from data_tools.synthetic.shapes.thing import Thing
from razer.arrays import Float32Array, Float64Array, Uint8Array

FULL = 128  # the value of the image at which a colour is shown as it is
_GAMMA = 2.2
_MIDDLE = 0.55  # what half of the light is brought to, before gamma
_SHOULDER, _BRIGHTEST = 0.9, 1.3
_WHITE_BALANCE = 0.6  # how much of the light's own colour a camera takes away
_DARKEST = 0.06  # of the middle, also in gaps that no ray leaves
_PASSES = 6
_KEPT = 4
# Of even light: direction towards each lamp, share of the light; the rest comes from everywhere.
_LAMPS = (((0.35, 0.5, 0.8), 0.3), ((-0.7, -0.35, 0.35), 0.2))
_AMBIENT = 0.68
_ROW = 4096


@dataclass(frozen=True, slots=True)
class LightMap:
    """image (H, W, 3) uint8, the factor on display colours times FULL; gradient (F, 2, 3) and origin (F, 2) take a
    world point on a face to (x, y) in it."""

    image: Uint8Array
    gradient: Float64Array
    origin: Float64Array


_made: OrderedDict[bytes, LightMap] = OrderedDict()


def light_map(things: Mapping[int, Thing], scene: o3d.t.geometry.RaycastingScene, light: Light) -> LightMap:
    """The light map of a world; the same world in the same light is computed once.

    Args:
        things: instance id -> Thing.
        scene: their quads, two triangles each, in this order.
        light: the time of day.
    """
    solids = [solid for thing in things.values() for solid in thing.solids]
    parts = [solid.quads.tobytes() + repr(solid.material).encode() for solid in solids]
    key = blake2b(b"".join([*parts, light.encode()])).digest()
    if key not in _made:
        _made[key] = _even(things) if light == "even" else _computed(things, scene, light)
        while len(_made) > _KEPT:
            _made.popitem(last=False)
    return _made[key]


def _computed(things: Mapping[int, Thing], scene: o3d.t.geometry.RaycastingScene, light: Light) -> LightMap:
    quads = np.concatenate([solid.quads for thing in things.values() for solid in thing.solids])
    grid = FaceGrid.over(quads)
    around = Surroundings.of(grid, quads, scene)
    emitted, looks = _emitted(things, grid, quads, light)
    outside = LIGHTING[light].outside
    falling = irradiance(around, emitted, _reflectance(things)[grid.face], outside)
    # Windows and lamps are small, and few rays meet them: what comes from them is averaged over more neighbours.
    direct = gathered(around, np.where(np.isnan(looks), 0, emitted).astype(np.float32), (0.0, 0.0, 0.0))
    rest = _smoothed(grid, np.where(around.buried[:, None], np.nan, falling - direct).astype(np.float32))
    direct = np.where(around.buried[:, None], np.nan, direct).astype(np.float32)
    for _ in range(_PASSES):
        direct = _smoothed(grid, direct)
    solids = [solid for thing in things.values() for solid in thing.solids]
    solid_of_face = np.repeat(np.arange(len(solids)), [len(solid.quads) for solid in solids])
    falling = smoothed_over_edges(grid, quads, solid_of_face, rest + direct)
    shown = _exposed(falling, grid, quads)
    shown = np.where(np.isnan(looks), shown, looks)
    image = (FULL * grid.image(shown)).clip(0, 255).astype(np.uint8)
    return LightMap(image, grid.gradient, grid.origin + grid.place)


def _even(things: Mapping[int, Thing]) -> LightMap:
    """One sample for each face, by its direction alone."""
    normals = quad_normals(np.concatenate([solid.quads for thing in things.values() for solid in thing.solids]))
    light = np.full(len(normals), _AMBIENT)
    for direction, strength in _LAMPS:
        light += strength * (normals @ (np.array(direction) / np.linalg.norm(direction))).clip(0)
    number = np.arange(len(normals))
    image = np.zeros((len(normals) // _ROW + 1, _ROW, 3), np.uint8)
    image[number // _ROW, number % _ROW] = np.rint(FULL * light.clip(0, 1))[:, None]
    place = np.stack([number % _ROW, number // _ROW], axis=1).astype(float)
    return LightMap(image, np.zeros((len(normals), 2, 3)), place)


def _reflectance(things: Mapping[int, Thing]) -> Float32Array:
    """The share (F, 3) of light that each face sends back: its mean colour, undone from the display's gamma."""
    materials = [solid.material for thing in things.values() for solid in thing.solids for _ in solid.quads]
    mean = np.array([np.add(material.dark, material.light) / 2 for material in materials]) / 255
    return (0.9 * mean**_GAMMA).astype(np.float32)


def _emitted(
    things: Mapping[int, Thing], grid: FaceGrid, quads: Float64Array, light: Light
) -> tuple[Float32Array, Float32Array]:
    """The radiance (N, 3) of the nodes, and how those look that shine by themselves, nan for the others."""
    lighting = LIGHTING[light]
    count = int(grid.counts.prod(axis=1).sum())
    emitted, looks = np.zeros((count, 3), np.float32), np.full((count, 3), np.nan, np.float32)
    points, last_face = grid.points(quads), 0
    for thing in things.values():
        for solid in thing.solids:
            faces = slice(last_face, last_face + len(solid.quads))
            last_face = faces.stop
            nodes = slice(int(grid.first[faces.start]), _end(grid, faces.stop, count))
            if solid.material.glow:
                emitted[nodes] = lighting.glow[solid.material.glow]
                looks[nodes] = lighting.looks[solid.material.glow]
            elif thing.class_name == "ceiling":
                low, high = solid.quads[..., :2].min(axis=(0, 1)), solid.quads[..., :2].max(axis=(0, 1))
                emitted[nodes] = ceiling_glow(points[nodes], low, high)[:, None] * np.array(
                    lighting.ceiling, np.float32
                )
    return emitted, looks


def _end(grid: FaceGrid, face: int, count: int) -> int:
    return int(grid.first[face]) if face < len(grid.first) else count


def _smoothed(grid: FaceGrid, values: Float32Array) -> Float32Array:
    """Values (N, 3) of the nodes averaged over their neighbours on the same face; nan where none is known is filled by
    the nearest on it, or is black."""
    image = grid.image(values)
    unknown = np.isnan(image[..., 0])
    weight = np.where(unknown, 0, 1).astype(np.float32)
    filled = np.where(unknown[..., None], 0, image)
    x, y = (grid.place[grid.face] + grid.cell()).T
    total, weights = np.zeros_like(values), np.zeros((len(values), 1), np.float32)
    for dx, dy in product((-1, 0, 1), repeat=2):
        total += filled[y + dy, x + dx]
        weights += weight[y + dy, x + dx, None]
    known = weights[:, 0] > 0
    total[known] /= weights[known]
    return total


def _exposed(falling: Float32Array, grid: FaceGrid, quads: Float64Array) -> Float32Array:
    """The factor (N, 3) on display colours under light (N, 3): a camera's exposure, white balance and shoulder."""
    area = np.linalg.norm(np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]), axis=1)
    weight = (area / grid.counts.prod(axis=1))[grid.face]
    brightness = falling.mean(axis=1)
    lit = brightness > 0
    if not lit.any():
        return np.zeros_like(falling)
    order = np.argsort(brightness[lit])
    total = np.cumsum(weight[lit][order])
    middle = brightness[lit][order][np.searchsorted(total, total[-1] / 2)]
    tint = np.average(falling[lit], axis=0, weights=weight[lit])
    gain = _MIDDLE / middle * (tint.mean() / tint) ** _WHITE_BALANCE
    factor = (np.maximum(falling, _DARKEST * middle) * gain) ** (1 / _GAMMA)
    room = _BRIGHTEST - _SHOULDER
    over = np.maximum(factor - _SHOULDER, 0)
    return np.minimum(factor, _SHOULDER + room * (1 - np.exp(-over / room))).astype(np.float32)
