"""Packs hold each array once, reuse what did not change, and notice what is not what was written."""

from __future__ import annotations

import numpy as np
import pytest

from app.stored_state.array_packs import PackReader, PackWriter, pack_path, remove_packs
from razer.errors import BadInput

RANDOM = np.random.default_rng(0)
BLOBS = [RANDOM.bytes(1000) for _ in range(10)]


def checkpoint(writer, blobs):
    writer.begin()
    places = [writer.put(blob) for blob in blobs]
    return places, writer.finish()


def size(folder):
    return sum(path.stat().st_size for path in folder.iterdir())


def test_what_did_not_change_is_not_written_again(tmp_path):
    writer = PackWriter(tmp_path, "map")
    checkpoint(writer, BLOBS)
    assert size(tmp_path) == 10_000
    places, packs = checkpoint(writer, [*BLOBS[:9], b"new", BLOBS[0]])
    assert size(tmp_path) == 10_003
    assert packs == [0, 1]
    reader = PackReader(tmp_path, "map")
    assert [bytes(reader.get(place)) for place in places] == [*BLOBS[:9], b"new", BLOBS[0]]


def test_a_folder_holds_at_most_twice_of_what_is_needed(tmp_path):
    writer = PackWriter(tmp_path, "map")
    kept = BLOBS[:5]
    for round_ in range(20):
        changing = [RANDOM.bytes(1000) for _ in range(5)]
        places, packs = checkpoint(writer, [*kept, *changing])
        remove_packs(tmp_path, "map", packs)
        assert size(tmp_path) <= 2 * 10_000 + 1000, round_
        reader = PackReader(tmp_path, "map")
        assert [bytes(reader.get(place)) for place in places] == [*kept, *changing]


def test_a_checkpoint_that_was_given_up_leaves_the_one_before(tmp_path):
    writer = PackWriter(tmp_path, "map")
    places, _ = checkpoint(writer, BLOBS)
    writer.begin()
    writer.put(b"half")
    writer.abandon()
    assert [bytes(PackReader(tmp_path, "map").get(place)) for place in places] == BLOBS
    again, packs = checkpoint(writer, BLOBS)
    assert again == places
    assert 0 in packs


def test_a_new_writer_does_not_touch_the_packs_of_the_one_before(tmp_path):
    places, _ = checkpoint(PackWriter(tmp_path, "map"), BLOBS)
    checkpoint(PackWriter(tmp_path, "map"), [b"other"])
    assert [bytes(PackReader(tmp_path, "map").get(place)) for place in places] == BLOBS


@pytest.mark.parametrize("harm", ["flipped", "cut", "gone"])
def test_harm_is_noticed(tmp_path, harm):
    places, _ = checkpoint(PackWriter(tmp_path, "map"), BLOBS)
    path = pack_path(tmp_path, "map", 0)
    data = bytearray(path.read_bytes())
    if harm == "gone":
        path.unlink()
    else:
        data[9_500] ^= 1
        path.write_bytes(data if harm == "flipped" else data[:9_900])
    with pytest.raises(BadInput, match="checkpoint cannot be used"):
        PackReader(tmp_path, "map").get(places[-1])
