"""Plans of a map from above."""

from __future__ import annotations

import numpy as np
import pytest

from app.comparison.top_view import TopView


@pytest.mark.parametrize("up", [(0, 0, 1.0), (0.1, -1.0, 0), (1, 1, 1.0), (0, 1, 0.05)])
def test_a_view_from_above_is_not_mirrored(up):
    view = TopView.of(np.array(up))
    assert np.cross(view.right, view.away) @ np.array(up) > 0.9 * np.linalg.norm(up)
    assert view.project(np.array([[view.right, 2 * view.away]])) == pytest.approx(np.array([[[1, 0], [0, 2]]]))
