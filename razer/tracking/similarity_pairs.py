"""Pairs that the similarity scale is learnt from: things of one frame, and detections with the track they lie on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from razer.arrays import Float64Array
from razer.detection.lifting import Detection
from razer.tracking.embedding_bank import EmbeddingBank
from razer.tracking.step_result import Candidate

# Geometric distance V up to which a detection is taken for a view of a track, whatever its embedding: below this
# intersection over union of 1/2 a part or a neighbour may fit as well.
MAX_GEOMETRY = 0.5


def unlike_cosines(detections: Sequence[Detection]) -> Float64Array:
    """Cosines (P,) of all pairs of detections of one frame in different masks: of unlike things, for the most part.
    Stuff is left out, as a frame shows one floor in several pieces."""
    detections = [d for d in detections if not d.is_stuff]
    if len(detections) < 2:
        return np.zeros(0)
    embeddings = np.stack([d.embedding for d in detections]).astype(np.float64)
    masks = np.array([d.mask for d in detections])
    is_pair = np.triu(masks[:, None] != masks, 1)
    return (embeddings @ embeddings.T)[is_pair]


def same_cosines(
    detections: Sequence[Detection], candidates: Sequence[Sequence[Candidate]], banks: Mapping[int, EmbeddingBank]
) -> Float64Array:
    """Mean cosines (P,) of detections to the observations of the track that they lie on, by geometry alone: the
    strongest hypothesis of the one track within MAX_GEOMETRY, where no other detection claims it.

    Args:
        detections: Those of one frame.
        candidates: Of each, with their geometric distances.
        banks: Of the tracks, before this frame's observations.
    """
    near = {
        i: [c.track_id for c in row if c.geometry <= MAX_GEOMETRY and c.track_id in banks]
        for i, row in enumerate(candidates)
    }
    claims = Counter(track_id for ids in near.values() for track_id in ids)
    pairs = [(i, ids[0]) for i, ids in near.items() if len(ids) == 1 and claims[ids[0]] == 1]
    return np.array([banks[t].means[0] @ detections[i].embedding for i, t in pairs], np.float64)
