"""Pages of maps in a real browser: offline and served."""

from __future__ import annotations

import numpy as np
import pytest

from app.page.html import page_html
from app.page.mesh_codec import encode_mesh
from app.page.packet import pack
from app.page.payload import growing_payload, map_header, page_payload
from app.page.write_page import write_page
from razer.mesh.labelled_mesh import LabelledMesh
from tests.app.page.test_bundle import VIEWER
from tests.support.browser import chromium, opened
from tests.support.map_server import serving
from tests.support.page_maps import room_map, room_mesh, save_room

pytestmark = pytest.mark.full

SIZES = [(1366, 768), (1920, 1080), (390, 844)]
LONGEST_TASK_MS = 200


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def offline(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    write_page(save_room(folder / "flat"), folder / "map.html")
    return f"file://{folder / 'map.html'}"


@pytest.fixture(scope="module")
def payload(tmp_path_factory):
    return page_payload(save_room(tmp_path_factory.mktemp("served") / "flat"))


def card(page):
    return page.locator("#card h2").inner_text().split()


def middle_of(page):
    box = page.locator("#view").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize(("width", "height"), SIZES)
def test_a_page_opens_without_complaint_or_request(browser, offline, width, height, theme):
    with opened(browser, offline, width, height, theme) as seen:
        seen.page.wait_for_timeout(1000)
        assert seen.complaints == []
        assert seen.elsewhere == []
        assert seen.page.locator("#count").text_content() == "4 instances in 4 classes"
        assert seen.page.locator("html").get_attribute("data-theme") == theme
        wide = seen.page.evaluate("document.documentElement.scrollWidth > innerWidth")
        assert not wide


def test_a_click_on_the_map_tells_of_the_thing_there(browser, offline):
    with opened(browser, offline) as seen:
        seen.page.get_by_role("button", name="chair 3").click()
        assert card(seen.page) == ["chair", "3"]
        seen.page.get_by_role("button", name="Close the card").click()
        assert seen.page.locator("#card").is_hidden()
        # The flight ended with the chair in the middle of the picture.
        seen.page.mouse.click(*middle_of(seen.page))
        seen.page.locator("#card h2").wait_for()
        assert card(seen.page) == ["chair", "3"]
        text = seen.page.locator("#card").inner_text()
        for expected in ("50 \u00d7 40 \u00d7 40 cm", "9 frames (0\u20132)", "stool", "floor 1"):
            assert expected in text
        seen.page.get_by_role("button", name="floor 1").last.click()
        assert card(seen.page) == ["floor", "1"]


def test_search_finds_kinds_and_says_what_is_not_there(browser, offline):
    with opened(browser, offline) as seen:
        seen.page.fill("#question", "furniture")
        seen.page.locator("text=2 things by this name or kind").wait_for()
        names = seen.page.locator(".row-name").all_inner_texts()
        assert sorted(names) == ["chair 3", "table 2"]
        seen.page.fill("#question", "piano")
        seen.page.locator("text=Nothing in this map has this name or kind").wait_for()
        assert seen.page.locator(".row").count() == 0


def test_the_state_is_in_the_address(browser, offline):
    with opened(browser, offline) as seen:
        seen.page.get_by_role("button", name="table 2").click()
        seen.page.get_by_role("button", name="Show it alone").click()
        seen.page.get_by_role("button", name="Class", exact=True).click()
        seen.page.wait_for_timeout(1200)
        address = seen.page.url
    with opened(browser, address) as seen:
        assert card(seen.page) == ["table", "2"]
        assert seen.page.get_by_role("button", name="Show it alone").get_attribute("aria-pressed") == "true"
        assert seen.page.locator("#mode").input_value() == "2"
        seen.page.wait_for_timeout(1000)
        assert seen.page.url == address


def test_keys_walk_measure_and_let_go(browser, offline):
    with opened(browser, offline) as seen:
        page = seen.page
        page.locator("#view").focus()
        page.keyboard.press("r")
        x, y = middle_of(page)
        page.mouse.click(x - 60, y + 40)
        page.wait_for_timeout(600)
        page.mouse.click(x + 60, y + 40)
        page.locator("#ruler-label").wait_for()
        assert page.locator("#ruler-label").inner_text().endswith(("cm", "m"))
        page.keyboard.press("Escape")
        assert page.locator("#ruler-label").is_hidden()
        page.keyboard.press("w")
        before = page.evaluate("location.hash")
        page.keyboard.down("w")
        page.wait_for_timeout(900)
        page.keyboard.up("w")
        page.wait_for_timeout(600)
        assert page.evaluate("location.hash") != before
        page.keyboard.press("Escape")
        page.keyboard.press("?")
        assert page.get_by_role("dialog").is_visible()
        assert seen.complaints == []


def test_the_picture_button_gives_a_picture(browser, offline, tmp_path):
    import cv2

    with opened(browser, offline) as seen:
        with seen.page.expect_download() as download:
            seen.page.get_by_role("button", name="Save a picture (S)").click()
        download.value.save_as(tmp_path / "picture.png")
    picture = cv2.imread(str(tmp_path / "picture.png"))
    assert picture.shape[0] >= 700
    assert picture.std() > 5  # the room, not only the ground


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [1366, 390])
def test_axe_finds_no_serious_fault(browser, offline, theme, width):
    script = VIEWER / "node_modules" / "axe-core" / "axe.min.js"
    if not script.is_file():
        pytest.skip("axe-core is not here: run npm ci in app/page/viewer")
    with opened(browser, f"{offline}#s=3", width, 844, theme) as seen:
        if width < 500:
            seen.page.get_by_role("button", name="Show or hide the list").click()
            seen.page.wait_for_timeout(600)
        seen.page.evaluate(script.read_text())
        found = seen.page.evaluate("axe.run()")["violations"]
        serious = [(fault["id"], [node["html"] for node in fault["nodes"]]) for fault in found
                   if fault["impact"] in ("serious", "critical")]  # fmt: skip
        assert serious == []


def test_no_long_task_on_half_a_million_triangles(browser, tmp_path):
    n = 501
    x, y = np.meshgrid(np.linspace(0, 8, n), np.linspace(0, 8, n), indexing="ij")
    vertices = np.stack([x, y, 0.3 * np.sin(3 * x) * np.cos(2 * y)], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1)
    halves = [np.stack([corner, corner + n, corner + n + 1], 1), np.stack([corner, corner + n + 1, corner + 1], 1)]
    instances = (1 + (vertices[:, 0] > 4) + 2 * (vertices[:, 1] > 4)).astype(np.int32)
    colors = np.full((len(vertices), 3), 150, np.uint8)
    encoded = encode_mesh(LabelledMesh(vertices, colors, instances, np.concatenate(halves).astype(np.int32)))
    header = map_header(room_map(), "large", with_relations=False) | {"mesh": encoded.header}
    assert encoded.header["triangles"] == 500_000
    (tmp_path / "large.html").write_text(page_html("inline", pack(header, encoded.sections)))
    with opened(browser, f"file://{tmp_path / 'large.html'}") as seen:
        page = seen.page
        page.wait_for_timeout(1000)
        while page.evaluate("window.longTasks.splice(0).length"):  # the end of loading
            page.wait_for_timeout(1500)
        begun = page.evaluate("performance.now()")  # tasks are told of after their end, those of loading perhaps later
        x, y = middle_of(page)
        for step in range(8):
            page.mouse.move(x + 10 * step, y)
        page.mouse.down()
        page.mouse.move(x - 100, y + 30, steps=6)
        page.mouse.up()
        page.get_by_role("button", name="Instance", exact=True).click()
        page.fill("#question", "chair")
        page.get_by_role("button", name="chair 3").click()
        page.wait_for_timeout(2500)
        tasks = page.evaluate("window.longTasks.map(({ startTime, duration }) => [startTime, duration])")
        assert max((duration for start, duration in tasks if start > begun), default=0) <= LONGEST_TASK_MS


def test_a_served_page_asks_and_says_what_is_not_in_the_map(browser, payload):
    with serving(payload) as (address, known), opened(browser, address) as seen:
        seen.page.fill("#question", "something to sit on")
        seen.page.keyboard.press("Enter")
        seen.page.locator("text=One thing to sit on").wait_for()
        assert "chair 3: or stool (15 %)" in seen.page.locator("#statement").inner_text()
        assert seen.page.locator(".chance.hit").all_text_contents() == ["80 %"]
        seen.page.fill("#question", "a grand piano")
        seen.page.keyboard.press("Enter")
        seen.page.locator("text=not in this map").wait_for()
        assert [question["text"] for question in known.asked] == ["something to sit on", "a grand piano"]
        assert (seen.complaints, seen.elsewhere) == ([], [])


def test_an_edit_stays_after_a_reload_and_can_be_undone(browser, payload):
    with serving(payload) as (address, known), opened(browser, address) as seen:
        page = seen.page
        page.get_by_role("button", name="chair 3").click()
        page.locator(".editing summary").click()
        page.get_by_label("Name or class").fill("throne")
        page.get_by_role("button", name="Rename").click()
        page.locator("#card h2", has_text="throne").wait_for()
        assert known.posted == [{"epoch": 0, "kind": "rename", "instance": 3, "name": "throne"}]
        page.reload()
        page.wait_for_selector("body[data-ready]")
        page.get_by_role("button", name="throne 3").first.wait_for()
        page.get_by_role("button", name="Undo the last edit").click()
        page.get_by_role("button", name="chair 3").first.wait_for()


def test_the_edit_of_another_shows_up_and_a_stale_one_is_told(browser, payload):
    with serving(payload) as (address, known), opened(browser, address) as seen:
        page = seen.page
        page.get_by_role("button", name="cup 4").click()
        page.locator(".editing summary").click()
        known.epoch += 1  # somebody else was faster, and the event is still on its way
        page.get_by_role("button", name="Rename").click()
        page.locator("#toast", has_text="somebody renamed it").wait_for()
        known.rename(2, "desk")
        page.get_by_role("button", name="desk 2").first.wait_for()


def test_a_map_grows_while_one_looks_at_it(browser):
    mesh, header = room_mesh(), {"format": 1, "epoch": 0}
    with serving(growing_payload(room_map(), "walk")) as (address, known):
        sections = {
            "positions": mesh.vertices.astype("<f4").tobytes(), "colors": mesh.colors.tobytes(),
            "instances": mesh.instances.astype("<i4").tobytes(), "triangles": mesh.triangles.astype("<u4").tobytes(),
        }  # fmt: skip
        block = {"key": [0, 0, 0], "vertices": len(mesh.vertices), "triangles": len(mesh.triangles)}
        known.blocks = pack(header | {"revision": 0, "blocks": []}, dict.fromkeys(sections, b""))
        with opened(browser, address) as seen:
            page = seen.page
            empty = page.locator("#view").screenshot()
            known.blocks = pack(header | {"revision": 5, "blocks": [block]}, sections)
            known.tell("map", {"epoch": 0, "frame": 12, "revision": 5})
            page.wait_for_timeout(3000)
            assert page.locator("#view").screenshot() != empty
            page.get_by_role("button", name="chair 3").click()
            page.mouse.click(*middle_of(page))
            page.wait_for_timeout(800)
            assert card(page) == ["chair", "3"]
            assert seen.complaints == []


def test_escape_closes_the_keys_and_lets_go_of_a_walk(browser, offline):
    with opened(browser, offline) as seen:
        page = seen.page
        page.keyboard.press("?")
        page.get_by_role("dialog").wait_for()
        page.keyboard.press("Escape")
        page.get_by_role("dialog").wait_for(state="hidden")
        page.keyboard.press("w")
        walking = page.get_by_role("button", name="Walk")
        assert walking.get_attribute("aria-pressed") == "true"
        page.keyboard.press("Escape")
        assert walking.get_attribute("aria-pressed") == "false"


def test_on_a_phone_the_list_makes_room_for_what_is_chosen(browser, offline):
    with opened(browser, offline, 390, 844) as seen:
        page = seen.page
        page.get_by_role("button", name="Show or hide the list").click()
        row = page.get_by_role("button", name="cup 4").first
        row.click()
        page.locator("#card h2", has_text="cup").wait_for()
        assert not row.is_visible()
