"""Which frames settings choose: as a slow list would, and nothing that is not there."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.frames.selection import selected_frames
from app.settings.run_config import InputSettings
from razer.errors import BadInput


class Clip(SimpleNamespace):
    """A recording of so many frames."""

    def __len__(self) -> int:
        return int(self.n)


@given(
    n=st.integers(1, 30),
    start=st.integers(0, 29),
    length=st.none() | st.integers(1, 40),
    stride=st.integers(1, 7),
    most=st.none() | st.integers(1, 12),
)
def test_frames_are_chosen_by_range_then_stride_then_count(
    n: int, start: int, length: int | None, stride: int, most: int | None
) -> None:
    end = None if length is None else start + length
    settings, clip = InputSettings(start=start, end=end, stride=stride, max_frames=most), Clip(name="clip", n=n)
    expected = []
    for index in range(n):
        is_chosen = index >= start and (end is None or index < end) and (index - start) % stride == 0
        if is_chosen and (most is None or len(expected) < most):
            expected.append(index)
    if start >= n and start:
        with pytest.raises(BadInput, match=f"clip has frames 0 to {n - 1}: --start {start} lies past its end"):
            selected_frames(clip, settings)
    else:
        assert list(selected_frames(clip, settings)) == expected
