"""Plots of an evaluation; with those of a comparison the only importers of matplotlib."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from app.evaluation.precision_recall_plot import precision_recall_figure
from razer.metrics.protocol.evaluation import Evaluation


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
    """Precision over recall at an overlap of 0.5, a panel for each class, as PNG; None without curves."""
    figure = precision_recall_figure(result)
    return None if figure is None else png(figure)


def png(figure: Figure) -> bytes:
    """The figure as a file."""
    buffer = BytesIO()
    FigureCanvasAgg(figure).print_png(buffer)
    return buffer.getvalue()
