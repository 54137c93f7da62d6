"""Plots of an evaluation; with those of a comparison the only importer of matplotlib."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from razer.metrics.protocol.evaluation import Evaluation

_MAX_CURVES = 12
_MERGED = "any"


def confusion_matrix(result: Evaluation) -> bytes | None:
    """True classes in rows, predicted ones in columns, each row as shares of its vertices, as PNG; None without
    classes."""
    if result.confusion is None:
        return None
    counts = np.array(result.confusion["counts"], float)
    names = [name or "none" for name in result.confusion["names"]]
    occurs = (counts.sum(axis=0) + counts.sum(axis=1)) > 0
    counts, names = counts[np.ix_(occurs, occurs)], [name for name, keep in zip(names, occurs, strict=True) if keep]
    if not names:
        return None
    side = 3 + 0.22 * len(names)
    figure = Figure(figsize=(side + 1, side), layout="constrained")
    axes = figure.add_subplot()
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    image = axes.imshow(shares, vmin=0, vmax=1, cmap="viridis")
    axes.set_xticks(range(len(names)), names, rotation=90, fontsize=7)
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.set(xlabel="predicted", ylabel="true", title="share of each true class")
    figure.colorbar(image, ax=axes, shrink=0.7)
    return png(figure)


def precision_recall(result: Evaluation) -> bytes | None:
    """Precision over recall at an overlap of 0.5: all classes merged, and those with most points, as PNG."""
    curves = {name: curve for name, curve in result.curves.items() if len(curve.recall)}
    if not curves:
        return None
    ranked = sorted(curves, key=lambda name: (name != _MERGED, -len(curves[name].recall), name))
    figure = Figure(figsize=(7.5, 5), layout="constrained")
    axes = figure.add_subplot()
    for name in ranked[:_MAX_CURVES]:
        style: dict[str, Any] = {"color": "black", "linewidth": 2.5} if name == _MERGED else {"linewidth": 1}
        label = "all merged" if name == _MERGED else name
        axes.plot(curves[name].recall, curves[name].precision, marker=".", label=label, **style)
    axes.set(xlabel="recall", ylabel="precision", xlim=(0, 1.02), ylim=(0, 1.02), title="instances at IoU 0.5")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7, loc="lower left")
    return png(figure)


def png(figure: Figure) -> bytes:
    """The figure as a file."""
    buffer = BytesIO()
    FigureCanvasAgg(figure).print_png(buffer)
    return buffer.getvalue()
