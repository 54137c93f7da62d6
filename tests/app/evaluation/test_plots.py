"""Precision over recall: each class has a panel that can be read, of one class as of two hundred."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from app.evaluation.precision_recall_plot import precision_recall_figure
from razer.metrics.instances.precision_recall import precision_recall
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import Evaluation


def evaluation(n_classes):
    rng = np.random.default_rng(n_classes)
    curves = {
        f"fire extinguisher {i}": precision_recall(rng.random(4), rng.random(4) < 0.8, 1) for i in range(n_classes)
    }
    merged = precision_recall(rng.random(60), rng.random(60) < 0.8, 9)
    nothing = precision_recall(np.zeros(0), np.zeros(0, np.bool_), 2)
    return Evaluation(PRESETS["default"], curves={"any": merged, **curves, "unseen": nothing}, n_true=60)


@pytest.mark.parametrize("n_classes", [0, 1, 5, 200])
def test_each_class_has_a_panel_and_no_text_lies_on_another(n_classes):
    figure = precision_recall_figure(evaluation(n_classes))
    (axes,) = figure.axes
    texts = [text for text in axes.texts if text.get_text().strip()]
    titles = [text for text in texts if "AP50" in text.get_text()]
    assert len(titles) == n_classes + 1
    assert any("no prediction: unseen" in text.get_text() for text in texts)
    renderer = FigureCanvasAgg(figure).get_renderer()
    boxes = np.array([text.get_window_extent(renderer).extents for text in texts])
    assert boxes.min() >= 0
    assert (boxes[:, 2:] <= figure.bbox.max).all()
    near = [(a, b) for a, b in itertools.combinations(range(len(boxes)), 2) if abs(boxes[a] - boxes[b]).max() < 400]
    for a, b in near:
        apart = (boxes[a, :2] >= boxes[b, 2:]).any() or (boxes[b, :2] >= boxes[a, 2:]).any()
        assert apart, (texts[a].get_text(), texts[b].get_text())
    assert min(text.get_fontsize() for text in texts) >= 7


def test_lines_of_one_class_lie_in_its_own_panel():
    figure = precision_recall_figure(evaluation(7))
    (axes,) = figure.axes
    blue = next(c for c in axes.collections if np.allclose(c.get_color()[0][:3], (0, 114 / 255, 178 / 255)))
    assert len(blue.get_segments()) == 7
    frames = next(c for c in axes.collections if len(c.get_segments()) == 8)  # with the one of all merged
    for line, frame in zip(blue.get_segments(), frames.get_segments()[1:], strict=True):
        assert (line.min(axis=0) >= frame.min(axis=0)).all()
        assert (line.max(axis=0) <= frame.max(axis=0)).all()


def test_without_curves_there_is_no_plot():
    assert precision_recall_figure(Evaluation(PRESETS["default"])) is None
