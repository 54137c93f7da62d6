"""The sheet of a comparison: both paths over one floor plan, where the maps differ, and what that comes to."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from app.comparison.compare_runs import Comparison
from app.comparison.plots import draw_paths
from app.comparison.top_view import TopView
from app.evaluation.plots import png
from app.pictures.camera import PictureCamera, fitted_camera
from app.pictures.map_picture import Scene, draw, render
from app.pictures.scenes import ceilings
from app.pictures.style_colors import VertexColors
from razer.arrays import Float32Array, Float64Array, FloatArray

_SIZE_IN, _DPI = (14.0, 7.6), 110
_LARGEST_PT, _LINE_PT = 17.0, 1400.0  # of the sentence, and of a letter times how many fit
_PLAN_PX = (900, 900)
_NEAR_M = 0.05
_MOST_M = 0.10  # the end of the scale of colours
_PALE = 0.62  # of white in the plan, so that paths stand out
# Light to dark in even steps, so that the order is plain without any colour.
_HEAT = LinearSegmentedColormap.from_list("distance", ["#dfe3e6", "#e9d8a6", "#ee9b3a", "#c8452f", "#6d1b3b"], N=256)
_INK, _QUIET = "#22262b", "#6b7077"


def sheet(result: Comparison) -> bytes:
    """The sheet as PNG."""
    figure = Figure(figsize=_SIZE_IN, dpi=_DPI, facecolor="white")
    figure.set_layout_engine("constrained", rect=(0.01, 0.01, 0.98, 0.86))
    said = summary(result)
    size_pt = min(_LARGEST_PT, _LINE_PT / len(said))
    figure.text(0.02, 0.95, said, fontsize=size_pt, weight="bold", color=_INK, va="center")
    plan, heat = figure.subplots(1, 2, width_ratios=(1, 1.3))
    _draw_plan(plan, result)
    _draw_heat(heat, result)
    if plan.lines:
        place = {"loc": "upper left", "bbox_to_anchor": (0.008, 0.93)}
        figure.legend(*plan.get_legend_handles_labels(), fontsize=11, ncols=3, frameon=False, **place)
    return png(figure)


def summary(result: Comparison) -> str:
    """What the comparison comes to, in one sentence."""
    parts = []
    if result.pose is not None:
        parts.append(f"paths {_length(result.pose.ate_rmse_m)} apart")
    if result.surface is not None:
        near = float((result.a_to_b_m <= _NEAR_M).mean())
        share = "over 99%" if 0.995 <= near < 1 else f"{near:.0%}"
        parts.append(f"{share} of A's surface within {1e2 * _NEAR_M:.0f} cm of B's")
    matching = result.instances
    in_a = len(matching.matched) + len(matching.missed)
    if in_a:
        more = f", {len(matching.extra)} more in B" if matching.extra else ""
        parts.append(f"{len(matching.matched)} of {in_a} instances in both{more}")
    text = "; ".join(parts) or "nothing to compare"
    return text[0].upper() + text[1:] + "."


def _length(metres: float) -> str:
    if metres < 0.01:
        return f"{1e3 * metres:.0f} mm"
    return f"{1e2 * metres:.1f} cm" if metres < 1 else f"{metres:.2f} m"


def _draw_plan(axes: Axes, result: Comparison) -> None:
    """The floor plan of A in pale colours under both paths."""
    view = TopView.of(result.a.panoptic.up_or_z)
    axes.set_title("the paths from above, dots at their starts", fontsize=11, color=_INK, loc="left")
    axes.set(xlabel=view.names[0], ylabel=view.names[1], aspect="equal")
    axes.tick_params(colors=_QUIET, labelsize=8)
    for spine in axes.spines.values():
        spine.set_visible(False)
    scene = Scene(
        result.a.panoptic.mesh,
        VertexColors.own(result.a.panoptic.mesh),
        result.a.panoptic.up_or_z,
        left_out=ceilings(result.a.panoptic),
    )
    points = _shown_points(result)
    if len(points):
        camera = _plan_camera(view, points)
        if len(scene.mesh.triangles):
            image = render(scene, camera).on("white").astype(np.float32)
            pale = _PALE * 255 + (1 - _PALE) * image
            axes.imshow(pale.astype(np.uint8), extent=_extent(view, camera), zorder=0, interpolation="antialiased")
    draw_paths(axes, view, result)


def _shown_points(result: Comparison) -> Float64Array:
    """The vertices of A and the places of the paths (N, 3)."""
    paths = (result.a.trajectory, result.b.trajectory, result.truth_trajectory)
    places = [path.world_from_camera[:, :3, 3] for path in paths if path is not None]
    return np.concatenate([result.a.panoptic.mesh.vertices.astype(np.float64), *places])


def _plan_camera(view: TopView, points: Float64Array) -> PictureCamera:
    axes = np.stack([view.right, -view.away, -np.cross(view.right, view.away)])
    return fitted_camera(axes, points, _PLAN_PX, 12, crops=True, is_orthographic=True)


def _extent(view: TopView, camera: PictureCamera) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of the picture in the plan, metres."""
    x, y = view.project(camera.eye)
    (width, height), (center_x, center_y), scale = camera.size, camera.center_px, camera.focal_px
    return (x - center_x / scale, x + (width - center_x) / scale, y - (height - center_y) / scale, y + center_y / scale)


def _draw_heat(axes: Axes, result: Comparison) -> None:
    """A from where most is seen, coloured by how far B's surface is."""
    axes.set_axis_off()
    axes.set_title("how far B's surface is from each place of A's", fontsize=11, color=_INK, loc="left")
    mesh = result.a.panoptic.mesh
    if not len(mesh.triangles) or result.surface is None:
        return
    colors = VertexColors(heat_colors(result.a_to_b_m), True)
    scene = Scene(mesh, colors, result.a.panoptic.up_or_z, left_out=ceilings(result.a.panoptic))
    axes.imshow(draw(scene).pixels, interpolation="antialiased")
    scale = ScalarMappable(Normalize(0, 1e2 * _MOST_M), _HEAT)
    bar = axes.figure.colorbar(scale, ax=axes, shrink=0.6, aspect=30, pad=0.01, extend="max")
    bar.set_label("cm", color=_QUIET)
    bar.outline.set_visible(False)
    bar.ax.tick_params(colors=_QUIET, labelsize=8)


def heat_colors(distances_m: FloatArray) -> Float32Array:
    """Colours (V, 3) from 0 to 255 of distances (V,), metres."""
    return (255 * _HEAT(np.clip(distances_m / _MOST_M, 0, 1))[:, :3]).astype(np.float32)
