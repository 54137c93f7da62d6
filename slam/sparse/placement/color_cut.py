"""Colour cut: the pictures of a part that show another place than the rest does, which looks alike.

Of two look-alikes no pair of pictures differs by much, and what is usual elsewhere is no less than that. Once pictures
lie where they belong, those of one place hardly differ at all, and those of two do by little again and again. So they
fall on two sides, such that pairs across have as many more other colours than is usual in the part as may be: a cut of
signed weights, by the spectral relaxation (Delorme and Poljak 1993), and then by what each picture gains.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import eigsh

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.submaps.placement_check import PlacedPair, color_differences
from slam.backend.view_checks.usual_colors import LEAST_USUAL, NOISE, UsualColors, place_weights, reading_weights
from slam.backend.view_overlap import near_poses
from slam.config import SlamConfig
from slam.sparse.measured_pair import Numbers
from slam.sparse.placement.placed_pictures import PlacedPictures

NEAREST = 16  # pictures that each is compared with, some 2 ms each
# What pairs across weigh together, for two sides to be two places; and times what those within the smaller side weigh
# for one. Two rooms on each other have 1.4 times as much; rooms next to each other, where few pictures show some of
# both, 0.05, and what was seen from a corner 0.6.
ENOUGH, LEAST_TIMES = 15.0, 1.0
# What pairs within the smaller side weigh for one place by picture of it, as much as two of them may: 5 in a room.
# Pictures that lie but roughly differ from all others as well, and go with nobody: 1.5.
LEAST_WITHIN = 3.0
STARTS = 3  # axes of the relaxation that are tried
FEWEST = 4  # pictures, that may be two places
PROBED_EVERY, WITHIN = 8, 0.25  # pairs that tell whether colours are clean, and the share of them that are of one place


def color_cut(pictures: PlacedPictures, poses: Mapping[int, Float64Array], config: SlamConfig) -> set[int]:
    """The numbers of the pictures on the smaller side; none, where all show one place.

    Args:
        pictures: all of them.
        poses: of the pictures (4, 4) of one part, by their numbers.
        config: the settings.
    """
    numbers = sorted(poses)
    if len(numbers) < FEWEST:
        return set()
    pairs = _near_pairs(pictures, poses, config)
    if not _are_clean(pairs, config):
        return set()
    weights = _weights(pairs, numbers, config)
    if weights.maximum(0).sum() / 2 < ENOUGH:  # all that could lie across
        return set()
    sides = _sides(weights)
    smaller = sides > 0 if (sides > 0).sum() <= len(sides) / 2 else sides < 0
    across, within = weights[smaller][:, ~smaller].sum(), -weights[smaller][:, smaller].sum() / 2
    are_two = across >= max(ENOUGH, LEAST_TIMES * within) and within >= LEAST_WITHIN * smaller.sum()
    return {numbers[row] for row in np.flatnonzero(smaller)} if are_two else set()


def _near_pairs(
    pictures: PlacedPictures, poses: Mapping[int, Float64Array], config: SlamConfig
) -> dict[Numbers, PlacedPair]:
    """Pictures and those nearest to each, by their numbers."""
    numbers = sorted(poses)
    stacked, pairs = np.stack([poses[n] for n in numbers]), dict[Numbers, PlacedPair]()
    for number in numbers:
        for row in near_poses(poses[number], stacked, config.loop_closure)[: NEAREST + 1].tolist():
            a, b = sorted((number, numbers[row]))
            if a != b and (a, b) not in pairs:
                pairs[a, b] = pictures.pair(a, b, inverse(poses[a]) @ poses[b])
    return pairs


def _are_clean(pairs: Mapping[Numbers, PlacedPair], config: SlamConfig) -> bool:
    """Whether pictures of one place hardly differ at all, as some pairs tell: else a little, again and again, is usual.
    Where two rooms lie on each other half of all pairs are of two."""
    some = color_differences([*pairs.values()][::PROBED_EVERY], config)
    return bool(some) and float(np.quantile([told.share for told in some.values()], WITHIN)) < LEAST_USUAL


def _weights(pairs: Mapping[Numbers, PlacedPair], numbers: list[int], config: SlamConfig) -> csr_array:
    """What pairs say (N, N) of pictures by number: more than 0 for two places, less for one."""
    told = color_differences([*pairs.values()], config)
    ends, placed = [*pairs], [*pairs.values()]
    rows = np.searchsorted(numbers, np.array([ends[n] for n in told], np.intp).reshape(-1, 2))
    separations = [placed[n].separation for n in told]
    shares, n_readings = (np.array([each[field] for each in told.values()], np.float64) for field in (0, 1))
    usual = UsualColors(separations, shares.tolist(), NOISE).at(separations)
    weights = place_weights(shares, usual) * reading_weights(n_readings)
    once = csr_array((weights, (rows[:, 0], rows[:, 1])), shape=(len(numbers), len(numbers)))
    return csr_array(once + once.T)


def _sides(weights: csr_array) -> Float64Array:
    """1 or -1 for each picture, such that weights (N, N) across add up to most."""
    start = np.random.default_rng(0).normal(size=weights.shape[0])  # along no axis, and always the same
    axes = eigsh(weights, k=STARTS, which="SA", v0=start, tol=1e-3)[1]
    found = [_improved(weights, np.where(axis >= 0, 1.0, -1.0)) for axis in axes.T]
    return min(found, key=lambda sides: float(sides @ (weights @ sides)))


def _improved(weights: csr_array, sides: Float64Array) -> Float64Array:
    """Sides that no single picture betters by changing to the other."""
    while True:
        gains = sides * (weights @ sides)
        best = int(np.argmax(gains))
        if gains[best] <= 1e-9:
            return sides
        sides[best] *= -1
