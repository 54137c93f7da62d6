"""A library on an object store, which throttles, fails, and breaks connections before or after it did as told."""

from __future__ import annotations

from datetime import timedelta

import pytest

from app.library.tables.instance_library import InstanceLibrary
from razer.errors import BadInput
from tests.app.library.test_writers import add, counted
from tests.support.cli import razer
from tests.support.faulty_store import BUCKET, faulty_store
from tests.support.served_maps import saved_map

pytestmark = pytest.mark.full


URI = f"s3://{BUCKET}/maps.lance"
FAULTS = ("throttled", "failed", "refused", "unanswered")


def test_a_library_on_an_object_store(capsys, tmp_path, monkeypatch):
    with faulty_store(monkeypatch):
        run = saved_map(tmp_path / "run")
        assert razer(capsys, "library", "add", run, "--library", URI)[0] == 0
        code, out, err = razer(capsys, "library", "query", "chair", "--library", URI, "--json")
        assert code == 0, err
        assert out.count('"class": "chair"') == 2
        assert razer(capsys, "library", "compact", "--library", URI)[0] == 0
        assert razer(capsys, "library", "remove", run, "--library", URI)[0] == 0
        assert '"maps": []' in razer(capsys, "library", "list", "--library", URI, "--json")[1]


@pytest.mark.parametrize("seed", range(3))
def test_faults_of_the_store_are_waited_out(monkeypatch, seed):
    with faulty_store(monkeypatch, seed, **dict.fromkeys(FAULTS, 0.15 / len(FAULTS))) as store:
        for number in range(10):
            add(URI, number)
            assert counted(URI) == number + 1
        InstanceLibrary(URI).tidy(timedelta(0))
        assert counted(URI) == 10
    assert set(FAULTS) <= store.faults.met.keys()


def test_a_store_that_is_not_there_is_one_plain_line(monkeypatch):
    with faulty_store(monkeypatch):
        add(URI, 0)
    with pytest.raises(BadInput) as told:
        InstanceLibrary(URI)
    assert str(told.value).startswith(URI)
    assert len(str(told.value)) < 400
