"""Registration of surfaces: planted motions are found, and what does not fit better, or moves too far, is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from razer.metrics.surface import surface_registration
from razer.metrics.surface.surface_registration import Surface, register_surfaces


def sheet(origin: tuple, right: tuple, up: tuple, size_m: tuple[float, float], spacing_m: float = 0.03) -> Surface:
    """A rectangle of triangles."""
    steps = [round(length / spacing_m) for length in size_m]
    u, v = np.meshgrid(*(np.linspace(0, length, n + 1) for length, n in zip(size_m, steps, strict=True)), indexing="ij")
    vertices = np.array(origin) + u[..., None] * np.array(right) + v[..., None] * np.array(up)
    number = np.arange(u.size).reshape(u.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return Surface(vertices.reshape(-1, 3), triangles)


def joined(*parts: Surface) -> Surface:
    offsets = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    triangles = [part.triangles + offset for part, offset in zip(parts, offsets, strict=True)]
    return Surface(np.concatenate([part.vertices for part in parts]), np.concatenate(triangles))


def corner(width_m: float = 2.0) -> Surface:
    """Floor and two walls, and a step in the floor."""
    return joined(
        sheet((0, 0, 0), (1, 0, 0), (0, 1, 0), (width_m, 2.0)),
        sheet((0, 0, 0), (0, 1, 0), (0, 0, 1), (2.0, 1.5)),
        sheet((0, 0, 0), (0, 0, 1), (1, 0, 0), (1.5, width_m)),
        sheet((0.8, 0.8, 0.4), (1, 0, 0), (0, 1, 0), (0.6, 0.6)),
    )


def moved(surface: Surface, rotation_deg: tuple, shift_m: tuple, noise_m: float = 0.0) -> Surface:
    turned = surface.vertices @ Rotation.from_euler("xyz", rotation_deg, degrees=True).as_matrix().T
    noise = noise_m * np.random.default_rng(0).normal(size=turned.shape)
    return Surface(turned + shift_m + noise, surface.triangles)


def placed(surface: Surface, motion: np.ndarray) -> np.ndarray:
    return surface.vertices @ motion[:3, :3].T + motion[:3, 3]


@pytest.mark.parametrize("noise_m", [0.0, 0.004])
def test_a_small_motion_is_found_and_kept(noise_m: float) -> None:
    target = corner()
    planted = {"rotation_deg": (1.0, -0.7, 0.5), "shift_m": (0.02, -0.03, 0.015)}
    source = moved(target, **planted, noise_m=noise_m)
    result = register_surfaces(source, target)
    assert result.rejected is None
    off = placed(moved(target, **planted), result.motion) - target.vertices
    assert np.linalg.norm(off, axis=1).max() < 0.002
    assert result.fit_after_m is not None
    assert result.fit_before_m is not None
    assert result.fit_after_m < 0.5 * result.fit_before_m
    shifts = placed(source, result.motion) - source.vertices
    assert result.moved_m == pytest.approx(np.sqrt((shifts**2).sum(axis=1).mean()), rel=1e-6)
    assert result.moved_deg == pytest.approx(np.degrees(Rotation.from_matrix(result.motion[:3, :3]).magnitude()))


def test_what_only_one_map_has_does_not_pull() -> None:
    target = corner()
    shift = (0.02, -0.01, 0.02)
    more = joined(target, sheet((0.2, 1.2, 0.06), (1, 0, 0), (0, 1, 0), (0.5, 0.5)))  # 6 cm above the floor
    source = moved(more, (0.5, 0.5, 0.0), shift)
    result = register_surfaces(source, target)
    assert result.rejected is None
    assert np.linalg.norm(placed(source, result.motion) - more.vertices, axis=1).max() < 0.003


def test_surfaces_that_fit_already_are_left_exactly_where_they_are() -> None:
    surface = corner()
    result = register_surfaces(surface, surface)
    assert (result.motion == np.eye(4)).all()
    assert result.rejected is not None
    assert "not fit better" in result.rejected


def test_a_motion_beyond_the_bound_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    target = corner()
    source = moved(target, (0.0, 0.0, 0.0), (0.03, 0.03, 0.03))
    assert register_surfaces(source, target).rejected is None
    monkeypatch.setattr(surface_registration, "MAX_MOVE_M", 0.04)
    result = register_surfaces(source, target)
    assert (result.motion == np.eye(4)).all()
    assert "more than 4 cm" in str(result.rejected)
    assert result.moved_m == pytest.approx(0.03 * np.sqrt(3), abs=0.002)


def test_along_a_bare_wall_nothing_slides() -> None:
    wall = sheet((0, 0, 0), (1, 0, 0), (0, 0, 1), (3.0, 2.0))
    shifted = moved(wall, (0.0, 0.0, 0.0), (0.2, 0.03, 0.1), noise_m=0.002)
    result = register_surfaces(shifted, wall)
    assert result.rejected is None
    step = placed(shifted, result.motion) - shifted.vertices
    assert step.mean(axis=0) == pytest.approx([0, -0.03, 0], abs=0.004)


@pytest.mark.parametrize("far_m", [0.5, 50.0])
def test_surfaces_that_do_not_meet_are_left(far_m: float) -> None:
    surface = sheet((0, 0, 0), (1, 0, 0), (0, 1, 0), (1.5, 1.5))
    result = register_surfaces(moved(surface, (0, 0, 0), (0, 0, far_m)), surface)
    assert (result.motion == np.eye(4)).all()
    assert "too little in common" in str(result.rejected)


def test_an_empty_map_has_nothing_to_refine_by() -> None:
    nothing = Surface(np.zeros((0, 3)), np.zeros((0, 3), int))
    assert "without surface" in str(register_surfaces(corner(), nothing).rejected)
    assert "without surface" in str(register_surfaces(nothing, corner()).rejected)
