"""A walking person as solids, at any point of a stride."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import ball, soft_box, tapered, tube
from data_tools.synthetic.shapes.solids import Material, Point, Solid
from data_tools.synthetic.shapes.thing import Thing, tinted

_SWING = 0.42  # radians, of a leg from the vertical
_KNEE = 0.9


@dataclass(frozen=True, slots=True)
class Figure:
    """Somebody's height in metres and clothes."""

    height_m: float
    skin: Material
    hair: Material
    shirt: Material
    trousers: Material
    shoes: Material

    @classmethod
    def of(cls, rng: np.random.Generator) -> Figure:
        """Somebody by chance."""
        skin = tinted("smooth", m.around(rng, ((238, 202, 178), (222, 178, 148), (150, 108, 82)), 8), 0.06)
        hair = tinted("cloth", m.around(rng, ((52, 40, 32), (110, 80, 52), (150, 146, 140)), 8), 0.4, 0.2)
        shirt = tinted("cloth", m.hue(rng, (0.1, 0.6), (0.4, 0.9)), 0.2, 0.5)
        trousers = tinted("cloth", m.around(rng, ((52, 62, 88), (60, 60, 62), (120, 104, 84)), 8), 0.2, 0.5)
        return cls(float(rng.uniform(1.58, 1.88)), skin, hair, shirt, trousers, m.dark_plastic(rng))

    def walking(self, phase: float) -> Thing:
        """The person at a point 0..1 of two steps, above the origin, walking towards +y."""
        k = self.height_m / 1.75
        angle = 2 * np.pi * phase
        solids = [*self._body()]
        for side in (-1, 1):
            swing = _SWING * float(np.sin(angle)) * side
            solids += self._leg(side, swing, _KNEE * max(0.0, float(-np.cos(angle) * side)) * 0.6)
            solids += self._arm(side, -swing)
        scaled = [Solid(s.quads * k, s.uv * k, s.material) for s in solids]
        lowest = min(float(s.quads[..., 2].min()) for s in scaled)
        return Thing("person", tuple(scaled)).placed(0, 0, -lowest)

    def _body(self) -> list[Solid]:
        hips = soft_box((-0.17, -0.11, 0.84), (0.17, 0.11, 1.02), (0.05, 0.05, 0.04), self.trousers)
        trunk = tapered((-0.16, -0.1, 0.16, 0.1), (-0.2, -0.12, 0.2, 0.12), 0.98, 1.4, self.shirt)
        shoulders = tapered((-0.2, -0.12, 0.2, 0.12), (-0.07, -0.06, 0.07, 0.06), 1.4, 1.49, self.shirt)
        neck = tube((0, 0, 1.45), (0, 0.01, 1.54), 0.052, self.skin, 8)
        head = ball((0, 0.02, 1.63), (0.077, 0.098, 0.12), self.skin, 14, 8)
        hair = ball((0, -0.012, 1.665), (0.086, 0.1, 0.1), self.hair, 14, 8)
        nose = ball((0, 0.118, 1.615), (0.014, 0.02, 0.022), self.skin, 6, 4)
        return [hips, trunk, shoulders, neck, head, hair, nose]

    def _leg(self, side: int, swing: float, bend: float) -> list[Solid]:
        hip = (side * 0.09, 0.0, 0.9)
        knee = _from(hip, 0.42, swing)
        ankle = _from(knee, 0.4, swing - bend)
        shoe = soft_box((-0.045, -0.08, -0.07), (0.045, 0.17, 0.02), (0.03, 0.04, 0.03), self.shoes)
        upper = tube(hip, knee, 0.078, self.trousers, 8)
        return [upper, tube(knee, ankle, 0.055, self.trousers, 8), _at(shoe, ankle)]

    def _arm(self, side: int, swing: float) -> list[Solid]:
        shoulder = (side * 0.235, 0.0, 1.4)
        elbow = _from(shoulder, 0.29, swing)
        wrist = _from(elbow, 0.26, swing + 0.35)
        hand = ball(_from(wrist, 0.07, swing + 0.35), (0.035, 0.045, 0.08), self.skin, 8, 4)
        upper = tube(shoulder, elbow, 0.052, self.shirt, 8)
        joint = ball((side * 0.21, 0.0, 1.395), (0.062, 0.075, 0.06), self.shirt, 10, 6)
        return [joint, upper, tube(elbow, wrist, 0.038, self.shirt, 8), hand]


def _from(joint: Point, length: float, angle: float) -> Point:
    """The end of a limb that hangs from a joint, swung forwards by an angle in radians."""
    x, y, z = joint
    return x, y + length * float(np.sin(angle)), z - length * float(np.cos(angle))


def _at(solid: Solid, place: Point) -> Solid:
    return Solid(solid.quads + np.array(place), solid.uv, solid.material)
