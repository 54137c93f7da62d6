"""A library behind `razer serve --library`, and as tools for agents."""

from __future__ import annotations

import asyncio
import json
import re

import cv2
import numpy as np
import pytest
from fastapi.testclient import TestClient
from mcp import Client

from app.agents.serve_agents import tools_of
from app.library.add_run import add_run
from app.served_map.shared_library import SharedLibrary, map_key
from app.server.access_rules import AccessRules
from app.server.bounded_pool import BoundedPool
from app.server.guard import Guard
from app.server.serve_library import library_app
from razer.plugins import NO_TRUST
from tests.support.cli import razer
from tests.support.edited_maps import CHAIR, OTHER_CHAIR
from tests.support.served_maps import ADDRESS, TOKEN, problem_of, saved_map

ASK, MAPS = "/api/v1/library/query", "/api/v1/library/maps"


@pytest.fixture
def place(tmp_path):
    for name in ("one", "two"):
        add_run(saved_map(tmp_path / name), str(tmp_path / "maps.lance"))
    return tmp_path


def client_of(place, token=None):
    rules = AccessRules("127.0.0.1", token)
    app = library_app(SharedLibrary(str(place / "maps.lance"), NO_TRUST), BoundedPool(1, 8), rules)
    return TestClient(Guard(app, rules), base_url=ADDRESS, raise_server_exceptions=False)


def test_programs_ask_it(place):
    client = client_of(place)
    answer = client.post(ASK, json={"text": "chair", "where": "scene = 'two'"}).json()
    assert (answer["found"], answer["asked"]) == (True, 6)
    assert [(hit["scene"], hit["id"], hit["class"]) for hit in answer["hits"]] == [
        ("two", CHAIR, "chair"), ("two", OTHER_CHAIR, "chair"),
    ]  # fmt: skip
    assert client.post(ASK, json={"text": "piano"}).json()["statement"] == "not in any of these maps: piano"
    like = client.post(ASK, json={"like": f"{place / 'one'}:{CHAIR}", "by_scene": True}).json()
    assert {each["scene"] for each in like["scenes"]} == {"one", "two"}
    assert [each["scene"] for each in client.get(MAPS).json()["maps"]] == ["one", "two"]


@pytest.mark.parametrize(
    "body",
    [{}, {"text": "chair", "where": "colour = 1"}, {"text": "chair", "limit": 0}, {"text": "chair", "like": "a:1"}],
)
def test_what_cannot_be_asked_is_a_problem(place, body):
    assert problem_of(client_of(place).post(ASK, json=body))["status"] == 422


def test_people_ask_it_and_a_hit_opens_its_map(place):
    client = client_of(place)
    page = client.get("/", params={"q": "chair", "where": "scene = 'one'"})
    (link,) = set(re.findall(r"href='(/maps/\w+)#s=\d+'", page.text))
    assert link == f"/maps/{map_key(str(place / 'one'))}"
    opened = client.get(link)
    assert opened.status_code == 200
    assert "one · RAZER" in opened.text
    assert "not in any of these maps: piano" in client.get("/", params={"q": "piano"}).text
    assert "No field named colour" in client.get("/", params={"q": "chair", "where": "colour = 1"}).text
    assert problem_of(client.get("/maps/0000000000000000"))["status"] == 404


def test_nothing_that_is_typed_becomes_part_of_the_page(place):
    page = client_of(place).get("/", params={"q": "<script>x</script>", "where": "'\"><b>"})
    assert "<script" not in page.text
    assert "<b>" not in page.text
    assert "script-src" not in page.headers["content-security-policy"]


def test_a_token_is_asked_for(place):
    client = client_of(place, TOKEN)
    assert problem_of(client.post(ASK, json={"text": "chair"}))["status"] == 401
    signed_in = client.get("/", params={"token": TOKEN}, follow_redirects=False)
    assert signed_in.status_code == 303
    assert client.post(ASK, json={"text": "chair"}).status_code == 200


def test_a_hit_has_a_small_picture_where_its_run_has_one(place):
    run, big = saved_map(place / "seen"), np.full((300, 600, 3), 90, np.uint8)
    (run / "crops").mkdir()
    cv2.imwrite(str(run / "crops" / f"{CHAIR:04d}-{20 * CHAIR:06d}.jpg"), big)
    add_run(run, str(place / "maps.lance"))
    client, address = client_of(place), f"{MAPS}/{map_key(str(run))}/instances"
    picture = client.get(f"{address}/{CHAIR}/thumbnail.jpg")
    assert picture.headers["content-type"] == "image/jpeg"
    assert cv2.imdecode(np.frombuffer(picture.content, np.uint8), cv2.IMREAD_COLOR).shape == (64, 128, 3)
    assert problem_of(client.get(f"{address}/{OTHER_CHAIR}/thumbnail.jpg"))["status"] == 404
    assert f"{address}/{CHAIR}/thumbnail.jpg" in client.get("/", params={"q": "chair"}).text
    add_run(run, str(place / "maps.lance"), with_thumbnails=False)
    assert client.get(f"{address}/{CHAIR}/thumbnail.jpg").status_code == 404


def test_what_is_added_meanwhile_is_found(place):
    client = client_of(place)
    assert len(client.post(ASK, json={"text": "chair"}).json()["hits"]) == 4
    add_run(saved_map(place / "three"), str(place / "maps.lance"))
    assert len(client.post(ASK, json={"text": "chair"}).json()["hits"]) == 6


def test_agents_ask_it(place):
    async def use():
        async with Client(tools_of(None, library=SharedLibrary(str(place / "maps.lance"), NO_TRUST))) as client:
            names = {tool.name for tool in (await client.list_tools()).tools}
            found = await client.call_tool("search_library", {"text": "chair", "limit": 3})
            wrong = await client.call_tool("search_library", {"text": "chair", "where": "colour = 1"})
            return names, found.structured_content, wrong

    names, found, wrong = asyncio.run(use())
    assert names == {"search_library", "list_maps"}
    assert len(found["hits"]) == 3
    assert json.dumps(found["hits"][0]["class"]) == '"chair"'
    assert wrong.is_error
    assert "No field named colour" in wrong.content[0].text


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("serve",), "--library"),
        (("serve", "RUN", "--library", "L"), "--library"),
        (("mcp",), "--library"),
        (("mcp", "--library", "L", "--allow-edits"), "only searched"),
    ],
)
def test_one_of_a_run_and_a_library_is_needed(capsys, arguments, said):
    code, out, err = razer(capsys, *arguments)
    assert (code, out) == (2, "")
    assert said in err
