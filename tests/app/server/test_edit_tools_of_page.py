"""The tools of the page that point at the map itself, in a real browser before the real server."""

from __future__ import annotations

import json

import pytest

from razer import load_map
from tests.support.browser import opened
from tests.support.edited_maps import CHAIR, FLOOR, TABLE, WALL
from tests.support.served_maps import server_process

pytestmark = pytest.mark.full


@pytest.fixture
def seen(browser, folder):
    with server_process(folder) as (_, address), opened(browser, address) as page:
        yield page
        assert page.complaints == []


def tool(page, button: str, label: str) -> None:
    """Open the card of an instance and take up a tool of it; the view is the one of the whole map again after."""
    page.get_by_role("button", name=label).first.click()
    page.locator(".editing summary").click()
    page.get_by_role("button", name=button).click()
    page.get_by_role("button", name="Whole map").click()
    page.wait_for_timeout(800)


def places_of(page, label: str) -> list[tuple[float, float]]:
    """Places on the screen where the pointer says that it is over an instance."""
    box = page.locator("#view").bounding_box()
    hover, found = page.locator("#hover-label"), []
    for row in range(3, 17):
        for column in range(2, 19):
            x, y = box["x"] + box["width"] * column / 20, box["y"] + box["height"] * row / 20
            page.mouse.move(x, y)
            page.wait_for_timeout(60)
            if hover.is_visible() and hover.text_content() == label:
                found.append((x, y))
    assert found, f"the pointer never found {label}"
    return found


def edits(folder) -> list[dict]:
    return [json.loads(line) for line in (folder / "edits.jsonl").read_text().splitlines()[1:]]


def sizes(folder) -> dict[int, int]:
    return {item.id: item.n_vertices for item in load_map(folder).objects}


def test_a_click_on_its_neighbour_merges_a_thing_with_it(seen, folder):
    before, page = sizes(folder), seen.page
    tool(page, "Merge with …", f"chair {CHAIR}")
    page.mouse.click(*places_of(page, f"table {TABLE}")[0])
    page.get_by_text("Merged").wait_for()
    (entry,) = edits(folder)
    assert (entry["kind"], entry["instances"]) == ("merge", [CHAIR, TABLE])
    after = sizes(folder)
    assert CHAIR not in after or TABLE not in after
    assert sum(after.values()) == sum(before.values())


def test_a_choice_in_the_list_is_what_a_thing_is_merged_with(seen, folder):
    page = seen.page
    page.get_by_role("button", name=f"chair {CHAIR}").first.click()
    page.locator(".editing summary").click()
    page.get_by_role("button", name="Merge with …").click()
    page.locator("#toast", has_text=f"belongs to chair {CHAIR}").wait_for()
    page.get_by_role("button", name=f"table {TABLE}").first.click()
    page.locator("#toast", has_text="Merged").wait_for()
    (entry,) = edits(folder)
    assert (entry["kind"], entry["instances"]) == ("merge", [CHAIR, TABLE])


def test_three_points_of_a_table_top_lay_the_plane_that_cuts_the_wall_behind_it(seen, folder):
    page = seen.page
    mesh, whole = load_map(folder).mesh, sizes(folder)[WALL]
    height_m = mesh.vertices[mesh.instances == TABLE, 2].max()
    tool(page, "Split by plane", f"wall {WALL}")
    page.get_by_role("button", name=f"table {TABLE}").first.click()  # there its top is large
    page.wait_for_timeout(800)
    places = places_of(page, f"table {TABLE}")
    far = [place for place in places if place[1] == min(y for _, y in places)]
    near = [place for place in places if place[1] == sorted({y for _, y in places})[2]]
    for place in (far[0], far[-1], near[1]):  # all on its top
        page.mouse.click(*place)
        page.wait_for_timeout(400)
    page.locator("#toast", has_text="Split").wait_for()
    (entry,) = edits(folder)
    plane = entry["region"]["plane"]
    assert plane["normal"] == pytest.approx([0, 0, 1], abs=0.02)
    assert plane["offset_m"] == pytest.approx(height_m, abs=0.02)
    mesh, after = load_map(folder).mesh, sizes(folder)
    cut_off = mesh.vertices[mesh.instances == 7]
    assert cut_off[:, 2].min() > height_m - 0.02
    assert after[WALL] + after[7] == whole


def test_an_area_of_the_floor_is_given_to_the_table(seen, folder):
    before, page = sizes(folder), seen.page
    tool(page, "Give an area to …", f"floor {FLOOR}")
    page.mouse.click(*places_of(page, f"table {TABLE}")[0])
    page.get_by_text("Draw around").wait_for()
    box = page.locator("#view").bounding_box()
    across = [(0.1, 0.5), (0.9, 0.5), (0.9, 0.85), (0.1, 0.85), (0.1, 0.5)]
    points = [(box["x"] + x * box["width"], box["y"] + y * box["height"]) for x, y in across]
    page.mouse.move(*points[0])
    page.mouse.down()
    for point in points[1:]:
        page.mouse.move(*point, steps=8)
    page.mouse.up()
    page.get_by_text("Done", exact=True).wait_for()
    (entry,) = edits(folder)
    assert (entry["kind"], entry["from"], entry["to"]) == ("move_border", FLOOR, TABLE)
    after = sizes(folder)
    assert after[FLOOR] < before[FLOOR]
    assert after[FLOOR] + after[TABLE] == before[FLOOR] + before[TABLE]
