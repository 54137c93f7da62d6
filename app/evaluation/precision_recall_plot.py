"""Plot of precision over recall: a small panel for each class, since curves of many classes in one hide each other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from razer.arrays import Float64Array
from razer.metrics.instances.precision_recall import Curve
from razer.metrics.protocol.evaluation import Evaluation

_MERGED = "any"
_MAX_NAME = 20
_MAX_COLUMNS = 12
# A panel with its title, in units of the panel's own sides, and the inches of such a unit.
_STEP_X, _STEP_Y = 1.25, 1.62
_UNIT_IN = 1.3
_BLACK, _GREY, _BLUE, _PALE = "black", "#b0b0b0", "#0072b2", "#e0e0e0"
_FRAME = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]], float)
_GRID = [np.array(line, float) for line in ([[0.5, 0], [0.5, 1]], [[0, 0.5], [1, 0.5]])]
_MAX_DOTS = 40  # more of them are a thicker line


@dataclass(frozen=True)
class _Panel:
    """A curve with its title; color: of its line."""

    title: str
    curve: Curve
    color: str


def precision_recall_figure(result: Evaluation) -> Figure | None:
    """All classes merged, then the classes by their number of true instances, each over the merged curve in grey, at
    IoU 0.5; the classes without a prediction are named below. None without curves."""
    curves = {name: curve for name, curve in result.curves.items() if len(curve.recall)}
    if not curves:
        return None
    merged = curves.pop(_MERGED, None)
    panels = _panels(result, curves)
    if merged is not None:
        title = _title("all merged", result.n_true, (result.class_agnostic or {}).get("ap50"))
        panels.insert(0, _Panel(title, merged, _BLACK))
    unpredicted = sorted(name for name, curve in result.curves.items() if not len(curve.recall) and name != _MERGED)
    return _figure(panels, merged, unpredicted)


def _panels(result: Evaluation, curves: Mapping[str, Curve]) -> list[_Panel]:
    panoptic: Mapping[str, Any] = (result.panoptic or {}).get("per_class") or {}
    aware: Mapping[str, Any] = (result.class_aware or {}).get("per_class") or {}
    counts = {name: panoptic.get(name, {}).get("n_true") for name in curves}
    ranked = sorted(curves, key=lambda name: (-(counts[name] or 0), name))
    titles = {name: _title(name, counts[name], aware.get(name, {}).get("ap50")) for name in ranked}
    return [_Panel(titles[name], curves[name], _BLUE) for name in ranked]


def _title(name: str, n_true: int | None, ap50: float | None) -> str:
    short = name if len(name) <= _MAX_NAME else f"{name[: _MAX_NAME - 1]}…"
    count = "" if n_true is None else f"{n_true} true, "
    value = "-" if ap50 is None or not math.isfinite(ap50) else f"{ap50:.2f}"
    return f"{short}\n{count}AP50 {value}"


def _figure(panels: Sequence[_Panel], merged: Curve | None, unpredicted: Sequence[str]) -> Figure:
    # All panels are drawn into one pair of axes: hundreds of pairs would take a minute.
    columns = min(_MAX_COLUMNS, max(3, math.ceil(math.sqrt(len(panels)))))
    rows = math.ceil(len(panels) / columns)
    note = _wrapped("no prediction: " + ", ".join(unpredicted), 24 * columns) if unpredicted else []
    low = -(rows - 1) * _STEP_Y - 0.55 - 0.16 * len(note)
    limits = (-0.5, columns * _STEP_X, low, 1.75)
    size = ((limits[1] - limits[0]) * _UNIT_IN, (limits[3] - limits[2]) * _UNIT_IN)
    figure = Figure(figsize=size)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=limits[:2], ylim=limits[2:])
    axes.set_axis_off()
    axes.text(0, 1.55, "instances at IoU 0.5: precision (up) over recall (right)", fontsize=11)
    origins = [np.array([i % columns * _STEP_X, -(i // columns) * _STEP_Y]) for i in range(len(panels))]
    _draw_frames(axes, origins, columns, len(panels))
    if merged is not None:
        _lines(axes, [origin + _line(merged) for origin in origins[1:]], _GREY, 1.2)
    for color in (_BLACK, _BLUE):
        chosen = [(origin, panel) for origin, panel in zip(origins, panels, strict=True) if panel.color == color]
        _lines(axes, [origin + _line(panel.curve) for origin, panel in chosen], color, 1.8)
        dots = [origin + _points(panel.curve) for origin, panel in chosen if len(panel.curve.recall) <= _MAX_DOTS]
        if dots:
            axes.plot(*np.concatenate(dots).T, ".", color=color, markersize=5)
    for origin, panel in zip(origins, panels, strict=True):
        axes.text(origin[0] + 0.5, origin[1] + 1.06, panel.title, fontsize=8, ha="center", va="bottom")
    axes.text(0, low + 0.1, "\n".join(note), fontsize=8, va="bottom")
    return figure


def _draw_frames(axes: Axes, origins: Sequence[Float64Array], columns: int, count: int) -> None:
    _lines(axes, [origin + line for origin in origins for line in _GRID], _PALE, 0.8)
    _lines(axes, [origin + _FRAME for origin in origins], "#606060", 0.8)
    for number, (x, y) in enumerate(origins):
        for value in (0, 0.5, 1):
            if number % columns == 0:
                axes.text(x - 0.05, y + value, f"{value:g}", fontsize=7, ha="right", va="center")
            if number + columns >= count:
                axes.text(x + value, y - 0.05, f"{value:g}", fontsize=7, ha="center", va="top")


def _lines(axes: Axes, lines: Sequence[Float64Array], color: str, width: float) -> None:
    axes.add_collection(LineCollection(list(lines), colors=color, linewidths=width))


def _points(curve: Curve) -> Float64Array:
    return np.stack([curve.recall, curve.precision], axis=1)


def _line(curve: Curve) -> Float64Array:
    """The points from the surest prediction on, after one at recall 0 with the precision of the surest ones."""
    return np.concatenate([[[0.0, curve.precision[-1]]], _points(curve)[::-1]])


def _wrapped(text: str, width: int) -> list[str]:
    lines = [""]
    for word in text.split(" "):
        if lines[-1] and len(lines[-1]) + len(word) >= width:
            lines.append("")
        lines[-1] += f"{word} "
    return lines
