"""Whatever is changed in a file, reading it ends in a value or in one plain line that names it."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rosbags")
pytest.importorskip("liblzfse")
from tests.fuzz.corpus import KINDS
from tests.fuzz.fuzzer import Fuzzer

QUICK_CHANGES = 2000
SLOW = {"opened run": 8, "masks": 4, "query": 8, "own": 2}  # how many times as long as others a change of them takes


def quick_changes(name: str) -> int:
    """How many changes of a kind the quick tests make, fewer where each takes long."""
    shares = {kind: 1 / SLOW.get(kind, 1) for kind in KINDS}
    return round(QUICK_CHANGES * shares[name] / sum(shares.values()))


@pytest.mark.parametrize("name", KINDS)
def test_no_change_of_a_file_ends_in_a_traceback(name: str, tmp_path: Path) -> None:
    fuzzer = Fuzzer(name, tmp_path, seed=1)
    fuzzer.read_valid()
    found = [finding for number in range(quick_changes(name)) if (finding := fuzzer.finding(number)) is not None]
    assert not found, "\n".join(map(str, found))


@pytest.mark.full
@pytest.mark.parametrize("name", KINDS)
def test_nor_do_many_changes(name: str, tmp_path: Path) -> None:
    fuzzer = Fuzzer(name, tmp_path, seed=2)
    found = [finding for number in range(1000) if (finding := fuzzer.finding(number)) is not None]
    assert not found, "\n".join(map(str, found))
