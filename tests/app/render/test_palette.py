"""Colours of pictures and timeline are those of the page."""

from __future__ import annotations

import re
from importlib.resources import files

import numpy as np

from app.render import palette

PAGE = (files("app.page") / "viewer" / "src" / "state" / "palette.ts").read_text(encoding="utf-8")


def table(name):
    """The colours of a constant of the page."""
    body = re.search(rf"const {name}: Rgb(?:\[\])? = (\[.*?\]);", PAGE, re.DOTALL)[1]
    return np.array(re.findall(r"\d+", body), int).reshape(-1, 3)


def test_the_tables_are_those_of_the_page():
    np.testing.assert_array_equal(palette.HUES, table("HUES"))
    np.testing.assert_array_equal(palette.STUFF, table("STUFF"))
    np.testing.assert_array_equal([palette.NOBODY], table("NOBODY"))
    assert f"[{', '.join(f'{shade:g}' for shade in palette.SHADES)}]" in PAGE
    share, grey = re.search(r"([\d.]+) \* part \+ [\d.]+ \* (\d+)", PAGE).groups()
    # A class of stuff has its hue, that much of it, on that grey.
    mixed = float(share) * palette.HUES + (1 - float(share)) * float(grey)
    np.testing.assert_allclose(palette.class_colors(np.arange(10), True), mixed, atol=0.51)


def test_places_and_classes_have_thirty_colours_each_unlike_its_neighbours():
    for colors in (palette.colors_by_place(np.arange(30), False), palette.class_colors(np.arange(30), False)):
        assert len({tuple(color) for color in colors.tolist()}) == 30
        assert np.abs(np.diff(colors.astype(int), axis=0)).sum(axis=1).min() > 60


def test_stuff_is_paler_than_things():
    chroma = {stuff: np.ptp(palette.colors_by_place(np.arange(5), stuff), axis=1).max() for stuff in (False, True)}
    assert chroma[True] < 30 < 60 < chroma[False]
