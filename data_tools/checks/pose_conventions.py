"""Pose conventions: the ways in which poses get written that are not camera-to-world, x right, y down, z forward."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from razer.arrays import Float64Array
from razer.geometry import inverse

_OPENGL = np.diag([1.0, -1.0, -1.0])
_NAMES = "xyz"


@dataclass(frozen=True, eq=False)
class Convention:
    """How a recording's poses may be meant; `fix` says how to make world_from_camera of them, "" if they are.

    inverted: they take world to camera. axes (3, 3): its columns are our right, down and forward in the axes of
    their camera. quaternion: their w x y z was read as x y z w. transposed: their rotations alone are."""

    fix: str
    inverted: bool = False
    axes: Float64Array = field(default_factory=lambda: np.eye(3))
    quaternion: bool = False
    transposed: bool = False

    def world_from_camera(self, written: Float64Array) -> Float64Array:
        """The pose (4, 4) that is meant by a written one, up to one change of the world for all."""
        meant = inverse(written) if self.inverted else written.copy()
        if self.quaternion:
            meant[:3, :3] = Rotation.from_quat(np.roll(Rotation.from_matrix(meant[:3, :3]).as_quat(), -1)).as_matrix()
        if self.transposed:
            meant[:3, :3] = meant[:3, :3].T
        change = np.eye(4)
        change[:3, :3] = self.axes
        meant = meant @ change
        # Axes of the other hand leave a pose rigid only if the world is mirrored too.
        return meant if np.linalg.det(self.axes) > 0 else np.diag([-1.0, 1.0, 1.0, 1.0]) @ meant


AS_WRITTEN = Convention("")
N_COMMON = 6
"""How many of conventions() are in wide use, or come from a wide-spread mistake."""


@lru_cache(maxsize=1)
def conventions() -> tuple[Convention, ...]:
    """All that are tried, commonest first; the first is AS_WRITTEN."""
    common = (
        AS_WRITTEN,
        Convention("they are world-to-camera: invert each 4x4 matrix", inverted=True),
        Convention(f"the camera's axes are OpenGL's, y up and z backward: {_right_factor(_OPENGL)}", axes=_OPENGL),
        Convention(
            f"they are world-to-camera with OpenGL axes: invert each 4x4 matrix, then {_right_factor(_OPENGL)}",
            inverted=True,
            axes=_OPENGL,
        ),
        Convention("their quaternions are w x y z: write qx qy qz qw", quaternion=True),
        Convention("their rotations are transposed: transpose each 3x3 rotation", transposed=True),
    )
    return common + tuple(_with_axes(axes, inverted) for inverted in (False, True) for axes in _other_axes())


def _with_axes(axes: Float64Array, inverted: bool) -> Convention:
    right, down, forward = (_axis(column) for column in axes.T)
    what = f"the camera's right, down and forward are their {right}, {down} and {forward}"
    how = _right_factor(axes)
    if np.linalg.det(axes) < 0:
        how += ", and on the left by diag(-1, 1, 1, 1), as their world is mirrored"
    start = "they are world-to-camera: invert each 4x4 matrix; " if inverted else ""
    return Convention(f"{start}{what}: {how}", inverted=inverted, axes=axes)


def _other_axes() -> list[Float64Array]:
    """The 48 ways to name three perpendicular axes but ours and OpenGL's; right-handed ones first."""
    every = [np.eye(3)[list(order)] * signs for order in permutations(range(3)) for signs in product((1, -1), repeat=3)]
    others = [axes for axes in every if not any((axes == known).all() for known in (np.eye(3), _OPENGL))]
    return sorted(others, key=lambda axes: -np.linalg.det(axes))


def _right_factor(axes: Float64Array) -> str:
    if np.count_nonzero(np.diag(axes)) == 3:
        numbers = ", ".join(f"{value:g}" for value in (*np.diag(axes), 1))
        return f"multiply each 4x4 matrix on the right by diag({numbers})"
    rows = ", ".join(f"[{', '.join(f'{value:g}' for value in row + 0.0)}]" for row in axes)
    return f"multiply each 3x3 rotation on the right by [{rows}]"


def _axis(column: Float64Array) -> str:
    place = int(np.abs(column).argmax())
    return ("-" if column[place] < 0 else "") + _NAMES[place]
