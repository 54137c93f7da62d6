"""Devices with screens, keys and plugs: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import ball, bars, beam, block, cylinder, disc, soft_box, tapered
from data_tools.synthetic.shapes.solids import Material, lathe
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import fitted, stretched, turned


def tv(rng: np.random.Generator) -> Thing:
    """A wide flat screen on two feet, off or showing a landscape."""
    width = rng.uniform(0.9, 1.45)
    height = width * 0.57
    case = m.dark_plastic(rng)
    shows = Material("landscape", (20.0, 44.0, 60.0), (206.0, 222.0, 236.0), 1.0, "screen")
    face = m.black_glass() if rng.uniform() < 0.7 else shows
    solids = [block(0, 0, 0.06, (width, 0.035, height), case)]
    solids.append(block(0, -0.03, 0.15, (width * 0.5, 0.03, height * 0.5), case))
    solids.append(fitted(block(0, 0.019, 0.075, (width - 0.03, 0.004, height - 0.03), face)))
    for side in (-1, 1):
        x = side * width * 0.35
        solids += [beam((x, 0, 0.065), (x, y, 0.008), 0.02, 0.014, case) for y in (-0.11, 0.11)]
        solids.append(block(x, 0, 0, (0.024, 0.25, 0.008), case))
    return Thing("tv", tuple(solids))


def monitor(rng: np.random.Generator) -> Thing:
    """A lit computer screen on a neck and a foot."""
    width, lift = rng.uniform(0.48, 0.64), rng.uniform(0.08, 0.16)
    height, case = width * rng.uniform(0.56, 0.64), m.dark_plastic(rng)
    foot, neck = (
        block(0, -0.02, 0, (0.24, 0.18, 0.015), case),
        block(0, -0.05, 0.015, (0.06, 0.03, lift + height * 0.4), case),
    )
    body = block(0, 0, lift, (width, 0.03, height), case)
    hub = block(0, -0.025, lift + height * 0.3, (0.12, 0.02, height * 0.35), case)
    face = fitted(block(0, 0.0165, lift + 0.02, (width - 0.02, 0.003, height - 0.03), m.display(rng)))
    return Thing("monitor", (foot, neck, body, hub, face))


def laptop(rng: np.random.Generator) -> Thing:
    """An open laptop."""
    width, depth = rng.uniform(0.31, 0.38), rng.uniform(0.22, 0.26)
    case = tinted("smooth", m.around(rng, ((185, 187, 190), (70, 72, 76), (215, 213, 208)), 6), 0.12)
    solids = [block(0, 0, 0, (width, depth, 0.016), case)]
    solids.append(
        fitted(
            turned(block(0, 0, 0.016, (width - 0.04, depth * 0.5, 0.002), _key_colours(rng)), "z", 180, (0, -0.03, 0))
        )
    )
    solids.append(block(0, depth * 0.31, 0.016, (width * 0.3, depth * 0.24, 0.0015), m.metal(rng)))
    lid = [block(0, -0.005, 0, (width, 0.01, depth), case)]
    lid.append(fitted(block(0, 0.001, 0.012, (width - 0.02, 0.002, depth - 0.024), m.display(rng))))
    lean = rng.uniform(8, 25)
    return Thing("laptop", (*solids, *(turned(s, "x", lean, (0, -depth / 2 + 0.006, 0.014)) for s in lid)))


def _key_colours(rng: np.random.Generator) -> Material:
    if rng.uniform() < 0.6:
        return Material("keys", (215.0, 215.0, 215.0), (52.0, 52.0, 56.0))
    return Material("keys", (80.0, 82.0, 86.0), (236.0, 236.0, 232.0))


def keyboard(rng: np.random.Generator) -> Thing:
    """A computer keyboard."""
    width, depth = rng.uniform(0.36, 0.46), rng.uniform(0.12, 0.16)
    case = m.dark_plastic(rng)
    body = block(0, 0, 0, (width, depth, 0.018), case)
    keys = turned(block(0, 0, 0.018, (width - 0.02, depth - 0.02, 0.008), _key_colours(rng)), "z", 180)
    return Thing("keyboard", (body, fitted(keys)))


def mouse(rng: np.random.Generator) -> Thing:
    """A computer mouse with a wheel."""
    shell, dark = m.dark_plastic(rng) if rng.uniform() < 0.6 else m.ceramic(rng), m.metal(rng)
    x, y = rng.uniform(0.028, 0.034), rng.uniform(0.048, 0.06)
    body = soft_box((-x, -y, 0), (x, y, 0.036), (0.014, 0.025, 0.017), shell)
    return Thing("mouse", (body, turned(cylinder(0.012, -0.004, 0.004, dark, 8), "y", 90, (0, 0.022, 0.029))))


def computer_tower(rng: np.random.Generator) -> Thing:
    """A desktop computer: case, drive bays, button and air slots."""
    width, depth, height = rng.uniform(0.17, 0.22), rng.uniform(0.38, 0.48), rng.uniform(0.36, 0.48)
    case, trim = m.dark_plastic(rng), m.metal(rng)
    front = depth / 2
    solids = [block(s * (width / 2 - 0.03), 0, 0, (0.04, depth - 0.06, 0.012), trim) for s in (-1, 1)]
    solids += [block(0, 0, 0.012, (width, depth, height - 0.012), case)]
    solids += [block(0, front + 0.004, height - z, (width - 0.03, 0.008, 0.036), trim) for z in (0.06, 0.105)]
    solids.append(disc(0.014, 0.006, (0, front, height - 0.15), trim, 10))
    solids += [block(0, front + 0.003, 0.05 + 0.025 * i, (width - 0.06, 0.006, 0.01), trim) for i in range(5)]
    return Thing("computer tower", tuple(solids))


def printer(rng: np.random.Generator) -> Thing:
    """A desktop printer: paper behind, output tray in front, a panel of buttons."""
    width, depth, height = rng.uniform(0.4, 0.5), rng.uniform(0.3, 0.38), rng.uniform(0.16, 0.24)
    case, dark, paper = m.ceramic(rng), m.dark_plastic(rng), tinted("smooth", (248.0, 248.0, 246.0), 0.05)
    half = depth / 2
    body = tapered((-width / 2, -half, width / 2, half), (-width / 2, -half, width / 2, half - 0.06), 0, height, case)
    slot = block(0, half - 0.005, 0.05, (width * 0.7, 0.05, 0.035), dark)
    tray = beam((0, half + 0.01, 0.045), (0, half + 0.15, 0.06), width * 0.6, 0.008, dark)
    sheet = beam((0, half + 0.01, 0.054), (0, half + 0.13, 0.067), width * 0.5, 0.004, paper)
    feed = beam((0, -half + 0.05, height - 0.02), (0, -half - 0.07, height + 0.16), width * 0.6, 0.01, dark)
    stack = beam((0, -half + 0.064, height - 0.02), (0, -half - 0.055, height + 0.19), width * 0.5, 0.008, paper)
    buttons = block(width * 0.3, 0.02, height, (width * 0.25, 0.1, 0.008), dark)
    return Thing("printer", (body, slot, tray, sheet, feed, stack, buttons))


def speaker(rng: np.random.Generator) -> Thing:
    """A loudspeaker box with a tweeter and a woofer."""
    width = rng.uniform(0.18, 0.28)
    depth, height = width * rng.uniform(1.0, 1.2), width * rng.uniform(1.6, 2.0)
    case = m.wood(rng) if rng.uniform() < 0.5 else m.dark_plastic(rng)
    dark, cone = m.dark_plastic(rng), m.metal(rng)
    solids = [
        block(0, 0, 0, (width, depth, height), case),
        block(0, depth / 2 + 0.004, 0.01, (width - 0.02, 0.008, height - 0.02), dark),
    ]
    for share, radius in ((0.32, 0.4), (0.78, 0.2)):
        at = (0.0, depth / 2 + 0.008, height * share)
        solids.append(disc(width * radius, 0.006, at, cone, 14))
        solids.append(disc(width * radius * 0.8, 0.003, (0.0, depth / 2 + 0.014, height * share), dark, 14))
        solids.append(disc(width * radius * 0.3, 0.01, (0.0, depth / 2 + 0.017, height * share), cone, 8))
    return Thing("speaker", tuple(solids))


def telephone(rng: np.random.Generator) -> Thing:
    """A desk telephone with a handset across and a field of keys."""
    case, light = m.dark_plastic(rng) if rng.uniform() < 0.6 else m.plastic(rng), m.ceramic(rng)
    k = rng.uniform(0.9, 1.15)
    base = tapered((-0.1, -0.1, 0.1, 0.1), (-0.095, -0.095, 0.095, 0.06), 0, 0.055, case)
    keys = [
        block(0.02 + 0.03 * i, -0.05 + 0.03 * j, 0.055, (0.02, 0.02, 0.006), light) for i in range(3) for j in range(4)
    ]
    grip = block(-0.06, -0.01, 0.085, (0.035, 0.2, 0.022), case)
    ends = [block(-0.06, y, 0.05, (0.045, 0.05, 0.045), case) for y in (-0.087, 0.067)]
    show = block(0.05, -0.081, 0.055, (0.075, 0.018, 0.005), m.display(rng))
    return Thing("telephone", tuple(stretched(part, (k, k, k)) for part in (base, *keys, grip, *ends, show)))


def fan(rng: np.random.Generator) -> Thing:
    """A standing fan: foot, pole, hub, four blades and a ring of guard wires."""
    height, radius = rng.uniform(0.9, 1.2), rng.uniform(0.17, 0.22)
    case, blade = m.ceramic(rng) if rng.uniform() < 0.5 else m.dark_plastic(rng), m.plastic(rng)
    solids = [cylinder(0.17, 0, 0.025, case, 14), cylinder(0.014, 0.025, height - 0.03, case, 8)]
    solids.append(turned(cylinder(0.05, 0, 0.175, case, 10), "x", -90, (0, -0.1, height)))
    angles = np.arange(10) * np.pi / 5
    rim = [(radius * float(np.cos(a)), 0.075, height + radius * float(np.sin(a))) for a in angles]
    solids += bars(rim, 0.01, 0.01, case, closed=True)
    solids += [beam((0, 0.1, height), end, 0.005, 0.005, case) for end in rim[::2]]
    for a in angles[1::3]:
        x, z = float(np.cos(a)), float(np.sin(a))
        solids.append(
            beam(
                (0.03 * x, 0.055, height + 0.03 * z),
                (0.85 * radius * x, 0.06, height + 0.85 * radius * z),
                0.004,
                0.09,
                blade,
            )
        )
    return Thing("fan", (*solids, ball((0, 0.09, height), (0.03, 0.02, 0.03), case, 8, 4)))


def lamp(rng: np.random.Generator) -> Thing:
    """A table lamp or a floor lamp: foot, pole and a conical shade."""
    tall = rng.uniform(1.35, 1.7) if rng.uniform() < 0.5 else rng.uniform(0.4, 0.6)
    shade_high, radius = 0.16 + tall * 0.08, 0.1 + tall * 0.07
    frame = m.metal(rng)
    shade = replace(tinted("fabric", m.hue(rng, (0.05, 0.4), (0.9, 0.98)), 0.2, 0.5), glow="lamp")
    base, upper = tall - shade_high, radius * rng.uniform(0.5, 0.8)
    foot = [cylinder(radius * 0.75, 0, 0.02, frame, 14), cylinder(0.012 + tall * 0.004, 0.02, base, frame, 8)]
    return Thing("lamp", (*foot, lathe([(0, base), (radius, base), (upper, tall), (0, tall)], shade, sides=16)))
