"""Plots of a comparison, in the frame of A: A is blue, B orange, the truth pale green."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.spatial import ConvexHull, QhullError

from app.comparison.compare_runs import Comparison
from app.comparison.top_view import TopView
from app.evaluation.plots import png
from razer.arrays import Float64Array, FloatArray, IndexArray
from razer.map_object import MapObject
from razer.metrics.trajectory_errors import PoseErrors

BLUE, ORANGE, RED, VIOLET = "#1f6fb4", "#e6781e", "#d62728", "#7b3fb5"
BLACK, PALE = "#222222", "#8fbf8f"
_CELL_M = 0.05
_MARGIN_M = 0.3
_LARGE_SHARE = 0.25  # of the plan's area
_MAX_STEP_RATIO = 2.5  # times the median time between poses: longer gaps are not drawn through
_MAX_LABELS = 60


def trajectories(result: Comparison) -> bytes:
    """Both trajectories, and the true one, from above, as PNG."""
    figure, axes, view = _top_view_axes(result)
    draw_paths(axes, view, result)
    ate = "" if result.pose is None else f"; ATE of B against A {100 * result.pose.ate_rmse_m:.1f} cm"
    axes.set_title(f"trajectories from above, dots at their starts{ate}")
    if axes.lines:
        figure.legend(fontsize=8, loc="outside lower center", ncols=3)
    return png(figure)


def draw_paths(axes: Axes, view: TopView, result: Comparison) -> None:
    """Draw both trajectories, and the true one, from above, with dots at their starts."""
    truth = ("truth", result.truth_trajectory, PALE, 6.0)  # broad, as one of the others often covers it
    for name, trajectory, color, width in (
        truth,
        ("A", result.a.trajectory, BLUE, 1.8),
        ("B", result.b.trajectory, ORANGE, 1.2),
    ):
        if trajectory is None:
            continue
        flat = view.project(trajectory.world_from_camera[:, :3, 3])
        label = _legend(result, name)
        for part in _gapless_parts(trajectory.stamps):
            axes.plot(*flat[part].T, color=color, linewidth=width, label=label)
            label = ""
        axes.plot(*flat[0], marker="o", color=color, markersize=6)


def errors(result: Comparison) -> bytes:
    """The errors of position and rotation over time, against the truth or else of B against A, as PNG."""
    figure = Figure(figsize=(8.5, 5.5), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    if result.errors is not None and (result.truth_a is None or result.truth_b is None):
        _draw_errors(upper, lower, result.errors, ORANGE, "B against A")
    elif result.truth_a is not None and result.truth_b is not None:
        _draw_errors(upper, lower, result.truth_a.errors, BLUE, "A against the truth")
        _draw_errors(upper, lower, result.truth_b.errors, ORANGE, "B against the truth")
    upper.set(ylabel="position, cm", title="errors of poses after alignment")
    lower.set(ylabel="rotation, degrees", xlabel="stamp, s")
    for axes in (upper, lower):
        axes.set_ylim(0, 1.25 * axes.get_ylim()[1])  # with room for the legend
        axes.grid(alpha=0.3)
        if axes.lines:
            axes.legend(fontsize=8, loc="upper left", ncols=2)
    return png(figure)


def _draw_errors(upper: Axes, lower: Axes, pose_errors: PoseErrors, color: str, name: str) -> None:
    for axes, values, unit in (
        (upper, 100 * pose_errors.distances_m, "cm"),
        (lower, pose_errors.angles_deg, "degrees"),
    ):
        label = f"{name}, RMS {np.sqrt(np.mean(values**2)):.2f} {unit}"
        for part in _gapless_parts(pose_errors.stamps):
            axes.plot(pose_errors.stamps[part], values[part], color=color, linewidth=1.3, label=label)
            label = ""


def instances(result: Comparison) -> bytes:
    """The boxes of both maps from above, pairs joined at their centres, missed and extra ones filled, as PNG."""
    figure, axes, view = _top_view_axes(result)
    matching = result.instances
    for match in matching.matched:
        _draw_box(axes, view, match.a, edgecolor=BLUE, facecolor="none")
        _draw_box(axes, view, match.b, edgecolor=ORANGE, facecolor="none")
        ends = view.project(np.stack([match.a.box.center, match.b.box.center]))
        axes.plot(*ends.T, color=BLACK, linewidth=1.2)
        axes.plot(*ends[0], marker="o", color=BLUE, markersize=3.5)
        axes.plot(*ends[1], marker="o", color=ORANGE, markersize=3.5)
        if len(matching.matched) <= _MAX_LABELS:
            _annotate(axes, ends[0], f"{match.a.id}={match.b.id} {match.a.class_name or ''}", BLACK)
    for unmatched, color in ((matching.missed, RED), (matching.extra, VIOLET)):
        for instance in unmatched:
            _draw_box(axes, view, instance, edgecolor=color, facecolor=color, alpha=0.3)
            if len(unmatched) <= _MAX_LABELS:
                _annotate(axes, view.project(instance.box.center), f"{instance.id} {instance.class_name or ''}", color)
    counts = f"{len(matching.matched)} matched, {len(matching.missed)} missed, {len(matching.extra)} extra"
    axes.set_title(f"instances from above: {counts}")
    outlines = [(BLUE, _legend(result, "A")), (ORANGE, _legend(result, "B"))]
    fills = [(RED, "missed: in A alone"), (VIOLET, "extra: in B alone")]
    handles: list[Artist] = [Line2D([], [], color=color, label=label) for color, label in outlines]
    handles += [Patch(color=color, alpha=0.3, label=label) for color, label in fills]
    figure.legend(handles=handles, fontsize=8, loc="outside lower center", ncols=4)
    return png(figure)


def _top_view_axes(result: Comparison) -> tuple[Figure, Axes, TopView]:
    """An empty plan of the place that holds both maps and trajectories, over the surface of A in grey."""
    view = TopView.of(result.a.panoptic.up_or_z)
    meshes = [view.project(run.panoptic.mesh.vertices.astype(np.float64)) for run in (result.a, result.b)]
    paths = [result.a.trajectory, result.b.trajectory, result.truth_trajectory]
    positions = [view.project(path.world_from_camera[:, :3, 3]) for path in paths if path]
    points = np.concatenate([*meshes, *positions])
    low, high = points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M
    figure = Figure(figsize=_figure_size(*(high - low)), layout="constrained")
    axes = figure.add_subplot()
    axes.set(xlabel=view.names[0], ylabel=view.names[1], aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.grid(alpha=0.25)
    if len(meshes[0]):
        _draw_plan(axes, meshes[0], low, high)
    return figure, axes, view


def _figure_size(width_m: float, height_m: float) -> tuple[float, float]:
    """Inches for a plan of this shape, with title and legend; a corridor stays readable."""
    return 9.0, float(np.clip(8.0 * height_m / width_m, 3.0, 16.0)) + 1.7


def _draw_plan(axes: Axes, flat: Float64Array, low: Float64Array, high: Float64Array) -> None:
    """Grey density of surface vertices: the darker, the more surface stands above a place."""
    bins = [np.arange(low[i], high[i] + _CELL_M, _CELL_M) for i in (0, 1)]
    counts, across, along = np.histogram2d(flat[:, 0], flat[:, 1], bins=bins)
    shades = np.log1p(counts.T)
    darkest = 2.5 * float(np.quantile(shades[shades > 0], 0.95))  # pale, so that lines stand out
    extent = (across[0], across[-1], along[0], along[-1])
    style: dict[str, Any] = {"cmap": "Greys", "interpolation": "bilinear", "origin": "lower", "zorder": 0}
    axes.imshow(shades, vmin=0, vmax=darkest, extent=extent, **style)


def _draw_box(axes: Axes, view: TopView, instance: MapObject, **style: Any) -> None:
    """The outline of a box; that of a floor or ceiling is faint, as everything lies within."""
    corners = view.project(instance.box.corners())
    try:
        hull = ConvexHull(corners)
        outline, area = corners[hull.vertices], hull.volume
    except QhullError:  # flat and upright, so that it is a line from above
        outline, area = corners, 0.0
    (left, right), (lower, upper) = axes.get_xlim(), axes.get_ylim()
    if area > _LARGE_SHARE * (right - left) * (upper - lower):
        style |= {"facecolor": "none", "linestyle": ":", "alpha": 0.5}
    axes.fill(*outline.T, linewidth=1.2, **style)


def _annotate(axes: Axes, place: Float64Array, text: str, color: str) -> None:
    style: dict[str, Any] = {"textcoords": "offset points", "xytext": (4, 4), "fontsize": 7, "color": color}
    axes.annotate(text.strip(), tuple(place), **style)


def _legend(result: Comparison, side: str) -> str:
    return {"A": f"A: {result.a.name}", "B": f"B: {result.b.name}"}.get(side, side)


def _gapless_parts(stamps: FloatArray) -> Sequence[IndexArray]:
    """Indices of poses, split where stamps have a gap."""
    steps = np.diff(stamps)
    return np.split(np.arange(len(stamps)), np.flatnonzero(steps > _MAX_STEP_RATIO * np.median(steps)) + 1)
