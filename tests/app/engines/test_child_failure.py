"""Why a child failed: the line of what it said that tells, and what would help."""

from __future__ import annotations

import pytest

from app.engines.child_failure import failure, last_words
from app.engines.child_process import ChildEnd

TRACEBACK = "Traceback (most recent call last):\n  File x\nZeroDivisionError: division by zero\n"


@pytest.mark.parametrize(
    ("log", "said"),
    [
        ("", "it said nothing"),
        ("1/3\nSegmentation fault\n", "Segmentation fault"),
        ("razer: it cannot be used\n", "it cannot be used"),
        ("WARNING: a helper was lost; what was mapped is saved\noutputs in out:\n  mesh.ply\n",
         "WARNING: a helper was lost; what was mapped is saved"),
        ("WARNING: frame 3 is skipped\n" + TRACEBACK, "ZeroDivisionError: division by zero"),
    ],
)  # fmt: skip
def test_the_line_that_says_why_is_found(log, said):
    assert last_words(log) == said


@pytest.mark.parametrize(
    ("code", "log", "remedy"),
    [
        (-9, "", "memory"),
        (2, "razer: memory ran out: use fewer or smaller frames\n", "memory"),
        (2, "razer: /out: No space left on device: free some space\n", "room"),
        (2, "razer: no camera poses\n", "none"),
        (1, TRACEBACK, "elsewhere"),
        (-11, "", "elsewhere"),
        (130, "", "elsewhere"),
        (None, "", "elsewhere"),
    ],
)
def test_what_would_help_depends_on_how_it_ended(code, log, remedy):
    problem = failure(ChildEnd(code, 0.0, 0.0), log)
    assert problem is not None
    assert problem[1] == remedy
    assert failure(ChildEnd(0, 0.0, 0.0), log) is None
