"""Matching of instance ids between two passes over the same detections, by how many detections they share."""

from __future__ import annotations

import numpy as np

from razer.arrays import Int32Array


def match_ids(before: Int32Array, after: Int32Array) -> dict[int, int]:
    """{id after: id before} of those that share most detections, each id once; before (N,) and after (N,) are the
    instances each detection was given to, 0 = nobody."""
    matched: dict[int, int] = {}
    used = set()
    for old, new in _pairs(before, after):
        if new not in matched and old not in used:
            matched[new] = old
            used.add(old)
    return matched


def majority_ids(before: Int32Array, after: Int32Array) -> dict[int, int]:
    """{id before: id after} of the instance that got most detections of each."""
    result: dict[int, int] = {}
    for old, new in _pairs(before, after):
        result.setdefault(old, new)
    return result


def _pairs(before: Int32Array, after: Int32Array) -> list[tuple[int, int]]:
    """Pairs (before, after), those that share most first."""
    is_owned = (before > 0) & (after > 0)
    pairs, shared = np.unique(np.stack([before, after])[:, is_owned], axis=1, return_counts=True)
    return [(int(old), int(new)) for old, new in pairs[:, np.argsort(-shared, kind="stable")].T]
