"""Anderson acceleration of an iteration that creeps. ICP's does, as points find other partners with each step and noise
of normals makes it too short (Anderson, J. ACM 1965; of ICP: Pavlov et al., ICRA 2018)."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array

FARTHEST = 10.0  # times what two steps differ by: partners that come and go are noise, and would be extrapolated


class AndersonAcceleration:
    """Steps that go to where those before lead. Only the last is remembered: after eight iterations views of a kitchen
    are a sixth as far from where they come to rest, and more of them add noise (two: a quarter, five: a third)."""

    def __init__(self) -> None:
        self._last: tuple[Float64Array, Float64Array] | None = None  # what was asked for, and what was done

    def accelerated(self, step: Float64Array, information: Float64Array) -> Float64Array:
        """What to add to the unknowns (N,) in place of the step that the equations ask for.

        What is asked for changes linearly with the unknowns, as far as the last two steps tell; so this leads to where
        least is asked for along the line through both, in sigmas of the information (N, N).
        """
        taken = step
        if self._last is not None:
            step_before, taken_before = self._last
            change = step - step_before
            weighted = information @ change
            share = float(step @ weighted) / max(float(change @ weighted), np.finfo(float).tiny)
            taken = step - min(max(share, -FARTHEST), 1.0) * (taken_before + change)
        self._last = step, taken
        return taken
