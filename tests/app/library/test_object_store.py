"""A library on an object store, which throttles, fails, and breaks connections before or after it did as told."""

from __future__ import annotations

from datetime import timedelta

import pytest

from app.library.tables.instance_library import InstanceLibrary
from razer.errors import BadInput
from tests.app.library.test_writers import add, counted
from tests.support.cli import razer
from tests.support.faulty_proxy import BUCKET, FAULTS, KEYS, faulty_store
from tests.support.served_maps import saved_map

pytestmark = pytest.mark.full


@pytest.fixture
def uri(tmp_path):
    return f"s3://{BUCKET}/{tmp_path.name}/maps.lance"  # stores of one process share what they hold


@pytest.fixture
def store(monkeypatch):
    def begin(proxy):
        for name, value in {**KEYS, "AWS_ENDPOINT_URL": proxy.url, "AWS_ALLOW_HTTP": "true"}.items():
            monkeypatch.setenv(name, value)
        return proxy

    return begin


def test_a_library_on_an_object_store(capsys, tmp_path, store, uri):
    with faulty_store() as proxy:
        store(proxy)
        run = saved_map(tmp_path / "run")
        assert razer(capsys, "library", "add", run, "--library", uri)[0] == 0
        code, out, err = razer(capsys, "library", "query", "chair", "--library", uri, "--json")
        assert code == 0, err
        assert out.count('"class": "chair"') == 2
        assert razer(capsys, "library", "compact", "--library", uri)[0] == 0
        assert razer(capsys, "library", "remove", run, "--library", uri)[0] == 0
        assert '"maps": []' in razer(capsys, "library", "list", "--library", uri, "--json")[1]


@pytest.mark.parametrize("seed", range(3))
def test_faults_of_the_store_are_waited_out(store, uri, seed):
    with faulty_store(0.15, seed) as proxy:
        store(proxy)
        for number in range(10):
            add(uri, number)
            assert counted(uri) == number + 1
        InstanceLibrary(uri).tidy(timedelta(0))
        assert counted(uri) == 10
    assert set(FAULTS) <= proxy.happened.keys()


def test_a_store_that_is_not_there_is_one_plain_line(store, uri):
    with faulty_store() as proxy:
        store(proxy)
        add(uri, 0)
    with pytest.raises(BadInput) as told:
        InstanceLibrary(uri)
    assert str(told.value).startswith(uri)
    assert len(str(told.value)) < 400
