"""Tools for agents, asked by the package's own client: in this process, over standard streams, and over HTTP."""

from __future__ import annotations

import asyncio
import re
import subprocess
import sys

import httpx
import pytest
from mcp import Client, StdioServerParameters

from app.agents.serve_agents import tools_of
from app.served_map.shared_map import SharedMap
from tests.support.edited_maps import CHAIR, LAMP, NAMES, OTHER_CHAIR, TABLE
from tests.support.served_maps import TOKEN, saved_map

READING = {"list_objects", "get_object", "query", "relations", "scene_graph"}
EDITING = {
    "rename_object", "relabel_object", "merge_objects", "delete_object", "split_object", "move_border", "undo", "redo",
}  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    return saved_map(tmp_path / "run")


def with_client(target, use):
    """What `use(client)` gives."""

    async def run():
        async with Client(target) as client:
            return await use(client)

    return asyncio.run(run())


def called(folder, *calls, allow_edits: bool = True):
    """The structured answers, or the error texts, of some calls one after the other."""

    async def use(client):
        results = [await client.call_tool(name, arguments) for name, arguments in calls]
        return [result.content[0].text if result.is_error else result.structured_content for result in results]

    return with_client(tools_of(SharedMap(folder), allow_edits=allow_edits), use)


async def tool_names(client):
    return {tool.name for tool in (await client.list_tools()).tools}


def test_tools_that_edit_are_there_only_where_they_are_allowed(folder):
    shared = SharedMap(folder)
    assert with_client(tools_of(shared, allow_edits=False), tool_names) == READING
    assert with_client(tools_of(shared, allow_edits=True), tool_names) == READING | EDITING


def test_every_tool_says_what_it_does_and_what_it_changes(folder):
    async def tools(client):
        return (await client.list_tools()).tools

    for tool in with_client(tools_of(SharedMap(folder), allow_edits=True), tools):
        assert len(tool.description) > 20
        assert tool.annotations.read_only_hint == (tool.name in READING)
        assert tool.output_schema is not None


def test_an_argument_that_a_tool_does_not_have_is_refused_by_name(folder):
    (told,) = called(folder, ("list_objects", {"class": "chair"}))
    assert "list_objects has no argument class; it has class_name, kind" in told


def test_what_a_map_holds(folder):
    objects, chairs, chair, found, missing, relations, graph = called(
        folder,
        ("list_objects", {}),
        ("list_objects", {"class_name": "chair", "limit": 1}),
        ("get_object", {"id": CHAIR}),
        ("query", {"text": "a lamp"}),
        ("query", {"text": "piano"}),
        ("relations", {}),
        ("scene_graph", {}),
    )
    assert {entry["id"]: entry["name"] for entry in objects["instances"]} == NAMES
    assert (chairs["total"], len(chairs["instances"])) == (2, 1)
    assert (chair["id"], chair["name"]) == (CHAIR, "chair")
    assert [hit["id"] for hit in found["hits"]] == [LAMP]
    assert "not in this map" in missing["statement"]
    assert relations["relations"]
    assert {node["class"] for node in graph["nodes"]} == set(NAMES.values())


@pytest.mark.parametrize(
    ("name", "arguments", "reason"),
    [
        ("get_object", {"id": 99}, "no instance 99"),
        ("get_object", {"id": 0}, "greater than or equal to 1"),
        ("query", {"text": ""}, "at least 1 character"),
        ("query", {"text": " "}, "empty text"),
        ("list_objects", {"limit": 0}, "greater than or equal to 1"),
        ("rename_object", {"id": CHAIR, "name": "x"}, "epoch"),
        ("rename_object", {"id": 99, "name": "x", "epoch": 0}, "99"),
        ("merge_objects", {"ids": [CHAIR, CHAIR], "epoch": 0}, "each instance is named once"),
        ("undo", {"epoch": 0}, "nothing to undo"),
    ],
)
def test_mistakes_are_told_to_the_agent_in_words(folder, name, arguments, reason):
    (answer,) = called(folder, (name, arguments))
    assert isinstance(answer, str)
    assert reason in answer


def test_edits_hold_and_late_ones_are_refused(folder):
    region = {"plane": {"normal": [1, 0, 0], "offset_m": 0.5}}
    answers = called(
        folder,
        ("rename_object", {"id": LAMP, "name": "torch", "epoch": 0}),
        ("rename_object", {"id": LAMP, "name": "stick", "epoch": 0}),
        ("merge_objects", {"ids": [CHAIR, OTHER_CHAIR], "epoch": 1}),
        ("split_object", {"id": TABLE, "region": region, "epoch": 2}),
        ("undo", {"epoch": 3}),
        ("redo", {"epoch": 4}),
        ("relabel_object", {"id": LAMP, "class_name": "wall", "epoch": 5}),
        ("delete_object", {"id": LAMP, "epoch": 6}),
        ("list_objects", {}),
    )
    assert "torch" in answers[1]
    assert [answer["epoch"] for answer in (*answers[:1], *answers[2:])] == [1, 2, 3, 4, 5, 6, 7, 7]
    assert answers[0]["edit"]["author"] == "agent"
    left = {entry["id"] for entry in answers[-1]["instances"]}
    assert {LAMP, OTHER_CHAIR}.isdisjoint(left)
    assert len(left) == len(NAMES) - 2 + 1


async def ask_for_lamps(client):
    names = await tool_names(client)
    return names, (await client.call_tool("query", {"text": "lamp"})).structured_content


def command(folder, *arguments) -> list[str]:
    return [sys.executable, "-m", "app", "mcp", str(folder), *arguments]


@pytest.mark.full
def test_over_standard_streams(folder):
    program, *arguments = command(folder, "--allow-edits")
    names, answer = with_client(StdioServerParameters(command=program, args=arguments), ask_for_lamps)
    assert names == READING | EDITING
    assert [hit["id"] for hit in answer["hits"]] == [LAMP]


@pytest.mark.full
def test_over_http_with_the_rules_of_the_interface(folder):
    process = subprocess.Popen(command(folder, "--http", "0"), stderr=subprocess.PIPE, text=True)
    try:
        line = process.stderr.readline()
        address = re.search(r"http://\S+", line)[0]
        names, answer = with_client(address, ask_for_lamps)
        assert names == READING
        assert [hit["id"] for hit in answer["hits"]] == [LAMP]
        assert httpx.post(address, headers={"Host": "evil.example"}, json={}).status_code == 421
        assert httpx.post(address, headers={"Origin": "http://evil.example"}, json={}).status_code == 403
    finally:
        process.terminate()
        assert process.wait(5) == 0


@pytest.mark.full
def test_over_http_with_a_token(folder):
    process = subprocess.Popen(command(folder, "--http", "0", "--token", TOKEN), stderr=subprocess.PIPE, text=True)
    try:
        address = re.search(r"http://\S+", process.stderr.readline())[0]
        assert httpx.post(address, json={}).status_code == 401
        authorised = httpx.post(address, json={}, headers={"Authorization": f"Bearer {TOKEN}"})
        assert authorised.status_code not in (401, 403)
    finally:
        process.kill()
        process.wait()
