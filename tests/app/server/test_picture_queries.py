"""Questions by picture."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from app.served_map.asked_map import AskedMap
from app.served_map.crop_pictures import NoPictures
from app.served_map.query_picture import MAX_BYTES
from app.server.served import Served
from razer.models.oracle.embedder import OracleEmbedder
from razer.query.text_queries import TextQueryEncoder
from tests.support.edited_maps import LAMP, hand_made
from tests.support.served_maps import API, client_of, problem_of


class SeesLamps(OracleEmbedder):
    """Takes bright pictures for lamps and dark ones for pianos."""

    def embed_region(self, rgb, mask):
        return self.embed_texts(["lamp" if rgb[mask].mean() > 128 else "piano"])[0]


class FixedMap:
    def __init__(self, embedder) -> None:
        self.current = AskedMap(0, replace(hand_made(), text_queries=TextQueryEncoder(embedder)), NoPictures())

    def tend(self) -> None:
        """Nothing."""


@pytest.fixture
def client():
    with client_of(Served(FixedMap(SeesLamps()))) as client:
        yield client


def picture(brightness: int) -> bytes:
    file = BytesIO()
    Image.fromarray(np.full((32, 32, 3), brightness, np.uint8)).save(file, "PNG")
    return file.getvalue()


def ask(client, data: bytes, **form):
    return client.post(f"{API}/query", files={"image": ("../../x.png", data, "image/svg+xml")}, data=form)


def test_a_picture_finds_what_looks_like_it(client):
    answer = ask(client, picture(250)).json()
    assert [hit["id"] for hit in answer["hits"]] == [LAMP]


def test_what_looks_like_nothing_here_is_not_in_this_map(client):
    answer = ask(client, picture(10)).json()
    assert not answer["found"]
    assert "not in this map" in answer["statement"]


@pytest.mark.parametrize("limit", ["0", "x", "-1", "1001", "1e3", "²"])
def test_the_limit_of_a_form_is_checked(client, limit):
    assert problem_of(ask(client, picture(250), limit=limit))["status"] == 422


def test_what_is_no_picture_is_refused(client):
    assert problem_of(ask(client, b"<svg/>"))["status"] == 422


def test_a_form_without_a_picture_is_refused(client):
    files = {"other": ("x.png", picture(1), "image/png")}
    assert problem_of(client.post(f"{API}/query", files=files))["status"] == 422
    assert problem_of(client.post(f"{API}/query", files={"image": (None, "text")}))["status"] == 422


def test_many_parts_are_refused(client):
    files = [("image", ("a.png", picture(1), "image/png"))] * 3
    assert problem_of(client.post(f"{API}/query", files=files))["status"] == 422
    fields = {f"field{i}": "x" for i in range(50)}
    assert problem_of(ask(client, picture(250), **fields))["status"] == 422


def test_large_pictures_are_refused_while_they_come(client):
    assert problem_of(ask(client, bytes(MAX_BYTES + 1)))["status"] == 413
    assert problem_of(ask(client, bytes(2 * MAX_BYTES)))["status"] == 413


def test_an_embedder_of_words_alone_says_so():
    with client_of(Served(FixedMap(OracleEmbedder()))) as client:
        assert "takes no pictures" in problem_of(ask(client, picture(250)))["detail"]
