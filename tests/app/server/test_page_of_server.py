"""The page in a real browser, from the real server: questions, edits that stay, and a token that opens it."""

from __future__ import annotations

import json

import httpx
import pytest

from razer import load_map
from tests.support.browser import opened
from tests.support.cli import ROOM_FRAMES, ROOM_SIZE, map_oracle_room
from tests.support.edited_maps import CHAIR, LAMP
from tests.support.served_maps import API, TOKEN, server_process

pytestmark = pytest.mark.full


def ask(page, question: str) -> None:
    page.fill("#question", question)
    page.keyboard.press("Enter")


def test_questions_light_up_what_is_meant_and_say_what_is_not_in_this_map(browser, folder):
    with server_process(folder) as (_, address), opened(browser, address) as seen:
        ask(seen.page, "a chair")
        seen.page.locator("#statement", has_text="2 instances in this map").wait_for()
        assert seen.page.locator(".chance.hit").count() == 2
        ask(seen.page, "piano")
        seen.page.locator("#statement", has_text="not in this map").wait_for()
        assert (seen.complaints, seen.elsewhere) == ([], [])


def test_an_edit_is_there_after_a_reload_for_others_and_in_the_folder_until_it_is_undone(browser, folder):
    with server_process(folder) as (_, address), opened(browser, address) as seen, opened(browser, address) as other:
        page = seen.page
        page.get_by_role("button", name=f"chair {CHAIR}").click()
        page.locator(".editing summary").click()
        page.get_by_label("Name or class").fill("throne")
        page.get_by_role("button", name="Rename").click()
        page.locator("#card h2", has_text="throne").wait_for()
        other.page.get_by_role("button", name=f"throne {CHAIR}").first.wait_for()
        page.reload()
        page.wait_for_selector("body[data-ready]")
        page.get_by_role("button", name=f"throne {CHAIR}").first.wait_for()
        entry = json.loads((folder / "edits.jsonl").read_text().splitlines()[1])
        assert (entry["kind"], entry["name"]) == ("rename", "throne")
        page.get_by_role("button", name="Undo the last edit").click()
        page.get_by_role("button", name=f"chair {CHAIR}").first.wait_for()
        other.page.get_by_role("button", name=f"chair {CHAIR}").first.wait_for()
        assert (seen.complaints, other.complaints) == ([], [])


def test_a_token_in_the_address_opens_the_page_and_leaves_it(browser, folder):
    with server_process(folder, "--token", TOKEN) as (_, address):
        place = f"{address}?token={TOKEN}"
        with opened(browser, place) as seen:
            assert TOKEN not in seen.page.url
            assert TOKEN not in seen.page.evaluate("document.cookie")
            ask(seen.page, "lamp")
            seen.page.locator("#statement", has_text="1 instance in this map").wait_for()
            assert (seen.complaints, seen.elsewhere) == ([], [])


def edit_panel(page, button: str, instance: int, name: str) -> None:
    page.get_by_role("button", name=f"{name} {instance}").first.click()
    page.locator(".editing summary").click()
    page.get_by_role("button", name=button).click()


def logged(folder) -> list[str]:
    return [json.loads(line)["kind"] for line in (folder / "edits.jsonl").read_text().splitlines()[1:]]


def test_a_class_is_set_and_a_thing_deleted_undone_and_deleted_again(browser, folder):
    with server_process(folder) as (_, address), opened(browser, address) as seen:
        page = seen.page
        page.get_by_role("button", name=f"chair {CHAIR}").click()
        page.locator(".editing summary").click()
        page.get_by_label("Name or class").fill("stool")
        page.get_by_role("button", name="Set class").click()
        page.get_by_role("button", name=f"stool {CHAIR}").first.wait_for()
        edit_panel(page, "Delete", LAMP, "lamp")
        page.get_by_role("button", name=f"lamp {LAMP}").first.wait_for(state="detached")
        page.get_by_role("button", name="Undo the last edit").click()
        page.get_by_role("button", name=f"lamp {LAMP}").first.wait_for()
        page.get_by_role("button", name="Redo").click()
        page.get_by_role("button", name=f"lamp {LAMP}").first.wait_for(state="detached")
        assert logged(folder) == ["relabel", "delete", "undo", "redo"]
        assert {item.id for item in load_map(folder).objects} == {1, 2, 3, 5, 6}
        assert seen.complaints == []


def test_what_a_lasso_goes_round_is_split_off(browser, folder):
    with server_process(folder) as (_, address), opened(browser, address) as seen:
        page = seen.page
        whole = {item.id: item.n_vertices for item in load_map(folder).objects}[LAMP]
        edit_panel(page, "Split by lasso", LAMP, "lamp")
        page.wait_for_timeout(2000)  # the camera flies there
        stage = page.locator("canvas").first.bounding_box()
        middle, width, height = stage["x"] + stage["width"] / 2, stage["width"], stage["height"]
        left = [(middle - 0.3 * width, 0.25), (middle, 0.25), (middle, 0.75), (middle - 0.3 * width, 0.75)]
        page.mouse.move(left[0][0], stage["y"] + left[0][1] * height)
        page.mouse.down()
        for x, y in [*left[1:], left[0]]:
            page.mouse.move(x, stage["y"] + y * height, steps=8)
        page.mouse.up()
        page.get_by_role("button", name="lamp 7").first.wait_for()
        assert logged(folder) == ["split"]
        sides = {item.id: item.n_vertices for item in load_map(folder).objects if item.id in (LAMP, 7)}
        assert sum(sides.values()) == whole
        assert min(sides.values()) > 0.2 * whole
        assert seen.complaints == []


def test_a_picture_of_a_wall_finds_it(browser, tmp_path):
    run, _ = map_oracle_room(tmp_path, ROOM_FRAMES, ROOM_SIZE, embedder="appearance")
    wall = max(load_map(run).objects, key=lambda item: item.n_vertices)
    with server_process(run) as (_, address), opened(browser, address) as seen:
        picture = httpx.get(f"{address.rstrip('/')}{API}/instances/{wall.id}/crop/0.jpg").content
        file = {"name": "thing.jpg", "mimeType": "image/jpeg", "buffer": picture}
        seen.page.set_input_files("input[aria-label='A picture']", file)
        seen.page.locator("#statement", has_text="in this map").wait_for()
        row = seen.page.get_by_role("button", name=f"wall {wall.id}").first
        assert row.locator(".chance.hit").count() == 1
        assert (seen.complaints, seen.elsewhere) == ([], [])
