"""Materials of furniture with plausible random colours."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

import numpy as np

from data_tools.synthetic.shapes.solids import Colour, Material
from data_tools.synthetic.shapes.thing import tinted

_WOODS: tuple[Colour, ...] = (
    (204, 164, 115),
    (222, 188, 145),
    (140, 100, 70),
    (226, 198, 156),
    (104, 76, 58),
    (170, 118, 80),
    (188, 160, 126),
)
_LACQUERS: tuple[Colour, ...] = (
    (242, 241, 237),
    (240, 239, 236),
    (236, 233, 224),
    (222, 222, 220),
    (238, 236, 230),
    (120, 122, 124),
)
_UPHOLSTERY: tuple[Colour, ...] = (
    (158, 156, 152),
    (118, 120, 126),
    (206, 188, 160),
    (84, 104, 138),
    (150, 122, 92),
    (62, 80, 116),
    (96, 124, 100),
    (176, 84, 66),
    (196, 150, 84),
)
_GLAZES: tuple[Colour, ...] = (
    (244, 243, 240),
    (240, 238, 232),
    (60, 92, 140),
    (186, 60, 50),
    (70, 74, 78),
    (206, 186, 150),
)
_METALS: tuple[Colour, ...] = ((175, 178, 182), (120, 122, 126), (58, 58, 62), (205, 205, 208), (170, 140, 85))
_CERAMICS: tuple[Colour, ...] = ((244, 244, 242), (240, 236, 226), (228, 232, 236))


def around(rng: np.random.Generator, colours: Sequence[Colour], spread: float = 10.0) -> Colour:
    """One of the colours, changed by up to `spread` in each channel."""
    base = np.array(colours[int(rng.integers(len(colours)))])
    red, green, blue = np.clip(base + rng.uniform(-spread, spread, 3), 15, 250)
    return float(red), float(green), float(blue)


def hue(rng: np.random.Generator, saturation: tuple[float, float], value: tuple[float, float]) -> Colour:
    """A colour of any hue with saturation and value (0..1) in the given ranges."""
    red, green, blue = colorsys.hsv_to_rgb(rng.uniform(), rng.uniform(*saturation), rng.uniform(*value))
    return 255 * red, 255 * green, 255 * blue


def wood(rng: np.random.Generator) -> Material:
    """Oak, beech, walnut and the like."""
    return tinted("wood", around(rng, _WOODS), 0.3, 1.2)


def lacquer(rng: np.random.Generator) -> Material:
    """Painted wood, mostly white."""
    return tinted("smooth", around(rng, _LACQUERS, 4), 0.06)


def wood_or_lacquer(rng: np.random.Generator) -> Material:
    """What cabinets are made of."""
    return wood(rng) if rng.uniform() < 0.6 else lacquer(rng)


def fabric(rng: np.random.Generator) -> Material:
    """Upholstery: greys, sands, blues, a red."""
    return tinted("cloth", around(rng, _UPHOLSTERY), 0.26, 0.6)


def leather(rng: np.random.Generator) -> Material:
    """Brown leather."""
    return tinted("smooth", around(rng, ((122, 84, 58), (150, 112, 80), (70, 58, 52))), 0.18, 0.5)


def patterned(rng: np.random.Generator) -> Material:
    """Printed cloth with two colours."""
    return Material("shapes", around(rng, _UPHOLSTERY), hue(rng, (0.02, 0.2), (0.85, 0.95)), 0.6)


def metal(rng: np.random.Generator) -> Material:
    """Steel, black iron or brass."""
    return tinted("smooth", around(rng, _METALS, 6), 0.25)


def plastic(rng: np.random.Generator) -> Material:
    """Plastic of any colour."""
    return tinted("smooth", hue(rng, (0.2, 0.85), (0.4, 0.9)), 0.15)


def dark_plastic(rng: np.random.Generator) -> Material:
    """The near-black of electronic devices."""
    return tinted("smooth", around(rng, ((48, 48, 52), (70, 70, 74)), 6), 0.3)


def ceramic(rng: np.random.Generator) -> Material:
    """White sanitary ware."""
    return tinted("smooth", around(rng, _CERAMICS, 4), 0.08)


def glaze(rng: np.random.Generator) -> Material:
    """Tableware, mostly white."""
    return tinted("smooth", around(rng, _GLAZES, 5), 0.1, 0.4)


def cardboard(rng: np.random.Generator) -> Material:
    """Brown corrugated board."""
    return tinted("smooth", around(rng, ((190, 150, 105), (205, 170, 125))), 0.2, 0.6)


def leaves(rng: np.random.Generator) -> Material:
    """Green foliage."""
    return Material("clouds", (38, 66, 30), around(rng, ((104, 150, 70), (84, 132, 74), (122, 150, 84)), 12), 0.4)


def display(rng: np.random.Generator) -> Material:
    """A lit screen with windows."""
    return Material("desktop", around(rng, ((12, 30, 70), (20, 40, 48)), 8), (232, 240, 248), 0.7, "screen")


def black_glass() -> Material:
    """Glass of ovens and of screens that are off."""
    return tinted("clouds", (34.0, 36.0, 40.0), 0.6)


def mirror_glass() -> Material:
    """Glass that shows a bright, blurred room."""
    return Material("clouds", (120.0, 140.0, 150.0), (232.0, 240.0, 244.0), 1.2)


def stone(rng: np.random.Generator) -> Material:
    """Marble or granite of worktops."""
    texture = "marble" if rng.uniform() < 0.5 else "terrazzo"
    return tinted(texture, around(rng, ((225, 222, 216), (96, 95, 94), (190, 175, 155))), 0.22, 0.9)


def linen(rng: np.random.Generator) -> Material:
    """White or pale bed linen, a little creased."""
    return tinted("creases", hue(rng, (0.0, 0.06), (0.87, 0.93)), 0.2, 0.9)


def bedding(rng: np.random.Generator) -> Material:
    """Duvets and blankets: pale, white or striped."""
    kind = int(rng.integers(3))
    if kind == 0:
        return tinted("creases", hue(rng, (0.06, 0.3), (0.66, 0.88)), 0.26, 1.0)
    if kind == 1:
        return linen(rng)
    return Material("stripes", around(rng, _UPHOLSTERY), hue(rng, (0.0, 0.06), (0.9, 0.97)), 1.1)
