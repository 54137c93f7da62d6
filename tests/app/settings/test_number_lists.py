"""Lists of whole numbers, as options take them."""

from __future__ import annotations

import pytest

from app.settings.number_lists import whole_numbers
from razer.errors import BadInput


def test_each_number_is_there_once_in_the_order_given():
    assert whole_numbers("--seeds", "3,1, 3,2,1", 0) == [3, 1, 2]


@pytest.mark.parametrize("text", ["", "1,", "one", "1,-1", "1.5"])
def test_anything_else_is_refused(text):
    with pytest.raises(BadInput, match="--seeds"):
        whole_numbers("--seeds", text, 0)
