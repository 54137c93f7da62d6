"""Pictures side by side under their captions."""

from __future__ import annotations

import numpy as np

from app.pictures.captions import captioned_row


def test_pictures_stand_side_by_side_as_they_are_under_their_captions() -> None:
    left = np.full((40, 300, 3), (10, 20, 30), np.uint8)
    right = np.full((40, 200, 3), (200, 100, 0), np.uint8)
    row = captioned_row([("left", left), ("", right)])
    above = row[:-40]
    assert row.shape == (94, 500, 3)
    assert (row[-40:, :300] == left).all()
    assert (row[-40:, 300:] == right).all()
    assert above[:, :300].min() < 100  # ink
    assert (above[:, 300:] == 255).all()
