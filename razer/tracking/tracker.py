"""Track management: tracks are matched, born, confirmed, fused and pruned (RAZER sections IV-C and IV-F)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from razer.boxes.rtree_index import BoxIndex
from razer.config import MapperConfig
from razer.detection.lifting import Detection
from razer.similarity.similarity_scale import MAX_LOG_ODDS, SimilarityScale
from razer.tracking.association import assign, find_candidates
from razer.tracking.evidence.pair_counts import Pair
from razer.tracking.evidence.view_consensus import MIN_VISIBLE_CELLS, ViewConsensus
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.similarity_pairs import same_cosines, unlike_cosines
from razer.tracking.step_result import Candidate, Decision, Outcome
from razer.tracking.stuff import surface_beneath
from razer.tracking.track import Track

# Log-odds of existence below which a track is forgotten. Between this and 0 it is no instance, but may become one.
PRUNED = -2.0
# Views of each of two tracks beyond which their embeddings say nothing new.
MAX_VIEWS_OF_EMBEDDINGS = 4


class Tracker:
    """All live tracks by id, with the R-tree over their boxes."""

    def __init__(self, config: MapperConfig, newest_id: int = 0, scale: SimilarityScale | None = None) -> None:
        """Ids of tracks are larger than `newest_id`; `scale` is that of the embedder's cosines, which learns on."""
        self.config = config
        self.scale = SimilarityScale() if scale is None else scale
        self.tracks: dict[int, Track] = {}
        self.newest_id = newest_id
        self._index = BoxIndex()
        self._consensus = ViewConsensus()
        self.detected: set[int] = set()
        """Tracks that were detected since tracks were last pruned."""

    def update(
        self,
        detections: Sequence[Detection],
        overlap: LabelOverlap,
        frame_index: int,
        novelty: float = 1.0,
        is_beside: bool = False,
    ) -> list[Decision]:
        """Give every detection of a frame to a track, an old one or a new one.

        Args:
            detections: Those of the frame.
            overlap: The labels under them, and how much of each track the frame shows.
            frame_index: The frame, as views of a track are noted.
            novelty: The share of a view that the frame is.
            is_beside: Whether the map lies beside the poses, so that no track can be missed.
        """
        settings = self.config.association
        candidates = find_candidates(detections, self.tracks, self._index, overlap, settings)
        banks = {track_id: track.bank for track_id, track in self.tracks.items()}
        self.scale.observe(unlike_cosines(detections), same_cosines(detections, candidates, banks))
        pairs = assign(candidates, settings.gate)
        mask_of = {track_id: detections[i].mask for i, track_id in pairs.items()}
        visible_things = [i for i in overlap.visible if i in self.tracks and self._is_thing(i)]
        others = self._consensus.apart(overlap, mask_of) if self.config.maintenance.spare_others else {}
        decisions = []
        for i, detection in enumerate(detections):
            outcome, track_id = self._destination(i, detection, pairs.get(i), candidates[i], overlap, mask_of)
            spares = {*others.get(pairs.get(i, 0), ()), *(visible_things if detection.is_stuff else ())}
            decisions.append(Decision(i, candidates[i], settings.gate, outcome, track_id, tuple(sorted(spares))))
        self._note_rivals(decisions, detections, mask_of, novelty)
        for decision in decisions:
            self._observe(decision, detections[decision.detection], frame_index, novelty)
        self._consensus.add(overlap, _born_masks(decisions, detections), novelty)
        self._count_hits(decisions, detections, novelty)
        if not is_beside:
            self._count_misses(decisions, overlap, novelty)
        return decisions

    def _destination(
        self,
        i: int,
        detection: Detection,
        assigned: int | None,
        candidates: Iterable[Candidate],
        overlap: LabelOverlap,
        mask_of: Mapping[int, int],
    ) -> tuple[Outcome, int]:
        if assigned is not None:
            return "matched", assigned
        if detection.is_stuff:
            beneath = surface_beneath({c.track_id: overlap.shared.get((i, c.track_id), 0) for c in candidates})
            return ("born", self._next_id()) if beneath is None else ("joined", beneath)
        owner = self._owner(i, detection, candidates, overlap)
        # One mask in several clusters is one thing; two masks over one track, frame after frame, are two things.
        if owner is None or (mask_of.get(owner, detection.mask) != detection.mask and self.tracks[owner].is_contested):
            return "born", self._next_id()
        return "joined", owner

    def _is_thing(self, track_id: int) -> bool:
        """Whether a track is a thing by now, which stuff must not swallow."""
        track = self.tracks[track_id]
        return track.confirmed and not track.is_stuff

    def _note_rivals(
        self, decisions: Sequence[Decision], detections: Sequence[Detection], mask_of: Mapping[int, int], novelty: float
    ) -> None:
        """Remember for each matched track whether a second mask lay on it as well."""
        joined = {(d.track_id, detections[d.detection].mask) for d in decisions if d.outcome == "joined"}
        rivalled = {track_id for track_id, mask in joined if mask_of.get(track_id, mask) != mask}
        for track_id in mask_of:
            self.tracks[track_id].note_rival(track_id in rivalled, novelty)

    def _owner(
        self, i: int, detection: Detection, candidates: Iterable[Candidate], overlap: LabelOverlap
    ) -> int | None:
        """The track a detection left over by the assignment is a further part of, if any."""
        settings = self.config.association
        if not settings.join:
            return None
        for candidate in sorted(candidates, key=lambda c: (c.semantic, c.track_id)):
            share = overlap.owned_share(i, candidate.track_id, detection.n_cells)
            if share >= settings.join_share and candidate.semantic <= settings.join_distance:
                return candidate.track_id
        return None

    def _next_id(self) -> int:
        self.newest_id += 1
        return self.newest_id

    def _observe(self, decision: Decision, detection: Detection, frame_index: int, novelty: float) -> None:
        track = self.tracks.get(decision.track_id)
        if track is None:
            settings = self.config.bank, self.scale, self.config.maintenance
            track = Track(decision.track_id, detection, frame_index, *settings)
            self.tracks[track.id] = track
        else:
            track.observe(detection, frame_index, novelty)
        self._index.put(track.id, track.box)

    def _count_hits(self, decisions: Sequence[Decision], detections: Sequence[Detection], novelty: float) -> None:
        """Count a detection of each track that there was before, by the best score where a frame has several."""
        scores: dict[int, float] = {}
        for decision in decisions:
            score = detections[decision.detection].score
            scores[decision.track_id] = max(score, scores.get(decision.track_id, 0.0))
        self.detected |= scores.keys()
        for track_id in scores.keys() - {d.track_id for d in decisions if d.outcome == "born"}:
            self.tracks[track_id].count_hit(scores[track_id], novelty)

    def _count_misses(self, decisions: Sequence[Decision], overlap: LabelOverlap, novelty: float) -> None:
        """Count a miss of each track that was in plain view and not detected: enough of its own voxels are visible,
        neither hidden nor out of view."""
        for track_id in overlap.visible.keys() - {decision.track_id for decision in decisions}:
            track, n_visible = self.tracks.get(track_id), overlap.visible[track_id]
            if track and n_visible >= MIN_VISIBLE_CELLS:
                track.count_miss(n_visible, novelty)

    def refreshed(self, track: Track) -> None:
        """Update the R-tree after a track's box was renewed."""
        self._index.put(track.id, track.box)

    def rename(self, new_ids: Mapping[int, int]) -> None:
        """Give tracks other ids {id: new id}, which no track has."""
        for track_id, new_id in new_ids.items():
            track = self.tracks.pop(track_id)
            track.id = new_id
            self.tracks[new_id] = track
            self._index.drop(track_id)
            self._index.put(new_id, track.box)
            self._consensus.replace(track_id, new_id)
        self.tracks = dict(sorted(self.tracks.items()))

    def fuse_duplicates(self) -> list[tuple[int, int]]:
        """Fuse tracks that many views show as one thing; returns (gone, survivor) in order."""
        fused: list[tuple[int, int]] = []
        if not self.config.maintenance.fuse_duplicates:
            return fused
        ranks = self._ranked_duplicates()
        while ranks:
            survivor, gone = max(ranks, key=ranks.__getitem__)
            fused.append(self._fuse(survivor, gone))
            ranks = {pair: rank for pair, rank in ranks.items() if {survivor, gone}.isdisjoint(pair)}
            ranks |= self._ranked_duplicates(survivor)
        return fused

    def fuse_stuff(self, meeting: Iterable[Pair]) -> list[tuple[int, int]]:
        """Fuse stuff tracks of one class that meet, given as pairs; returns (gone, survivor) in order."""
        fused: dict[int, int] = {}
        for pair in meeting:
            a, b = (self._latest(i, fused) for i in pair)
            if a != b and {a, b} <= self.tracks.keys():
                gone, survivor = self._fuse(min(a, b), max(a, b))
                fused[gone] = survivor
        return list(fused.items())

    def fuse_parts(self, parts: Iterable[tuple[int, int, float]]) -> list[tuple[int, int]]:
        """Fuse tracks that are parts of others, given as (part, whole, log-odds by all masks), the surest first, unless
        their embeddings speak against it; returns (gone, survivor) in order."""
        fused: dict[int, int] = {}
        enough = self.config.maintenance.fuse_log_odds
        for part, whole, views in parts if self.config.maintenance.fuse_duplicates else ():
            a, b = self._latest(part, fused), self._latest(whole, fused)
            are_things = a != b and all(i in self.tracks and not self.tracks[i].is_stuff for i in (a, b))
            if are_things and views + self._semantic_log_odds(b, a) >= enough:
                fused[a] = self._fuse(b, a)[1]
        return list(fused.items())

    @staticmethod
    def _latest(track_id: int, fused: Mapping[int, int]) -> int:
        while track_id in fused:
            track_id = fused[track_id]
        return track_id

    def fuse_alike(self, pairs: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
        """Fuse those of the given pairs (older id, newer id) that look alike; returns (gone, survivor) in order. A
        track is fused once, as what spoke for a second fusion may no longer hold after the first."""
        fused: dict[int, int] = {}
        for older, newer in pairs:
            is_free = {older, newer}.isdisjoint({*fused, *fused.values()}) and {older, newer} <= self.tracks.keys()
            is_free = is_free and not (self.tracks[older].is_stuff or self.tracks[newer].is_stuff)
            if is_free and self._semantic_log_odds(older, newer) >= 0:
                gone, survivor = self._fuse(older, newer)
                fused[gone] = survivor
        return list(fused.items())

    def _fuse(self, survivor: int, gone: int) -> tuple[int, int]:
        self.tracks[survivor].absorb(self.tracks[gone])
        self._index.put(survivor, self.tracks[survivor].box)
        self._remove(gone, survivor)
        return gone, survivor

    def _semantic_log_odds(self, a: int, b: int) -> float:
        """What the embeddings of two tracks say about their being one. Against it each view of both speaks anew, as a
        single vector may be wrong, but hardly several; for it they speak once, since neighbours often look alike."""
        log_odds = self.tracks[a].bank.log_odds_same(self.tracks[b].bank)
        n_views = min(self.tracks[a].hits, self.tracks[b].hits, MAX_VIEWS_OF_EMBEDDINGS)
        return log_odds if log_odds > 0 else n_views * log_odds

    def _ranked_duplicates(self, track_id: int = 0) -> dict[Pair, tuple[float, ...]]:
        """Pairs that are one thing by the masks of all views and by the embeddings, all of them or those of one track.
        The surest ranks highest, of pairs as sure as each other the larger one, as ids depend on the order of masks."""
        ranks: dict[Pair, tuple[float, ...]] = {}
        enough = self.config.maintenance.fuse_log_odds
        for pair, views in self._consensus.candidates(enough - MAX_LOG_ODDS, track_id):
            if any(self.tracks[i].is_stuff for i in pair):
                continue
            log_odds = round(views + self._semantic_log_odds(*pair), 9)
            if log_odds >= enough:
                ranks[pair] = log_odds, self._observed_cells(pair), -pair[0], -pair[1]
        return ranks

    def _observed_cells(self, pair: Pair) -> int:
        return sum(self.tracks[track_id].moments.count for track_id in pair)

    def prune(self, spare_confirmed: bool = False) -> list[int]:
        """Drop tracks that are phantoms by now, and those that own no surface any more."""
        detected, self.detected = self.detected, set()
        unspared = [t for t in self.tracks.values() if not (spare_confirmed and t.confirmed)]
        return self.drop(
            t.id for t in unspared if t.existence.log_odds < PRUNED or (self._is_bare(t) and t.id not in detected)
        )

    def drop_unconfirmed(self) -> list[int]:
        """Drop what is no instance when the run ends: unlikely tracks, those that own little of what their masks
        covered, and those that own less than the smallest detection shows."""
        min_confidence = self.config.maintenance.min_confidence
        min_voxels = self.config.lifting.min_cells
        return self.drop(
            t.id
            for t in self.tracks.values()
            if not t.confirmed or t.confidence < min_confidence or t.n_voxels < min_voxels
        )

    def drop(self, track_ids: Iterable[int]) -> list[int]:
        """Forget tracks; returns their ids."""
        gone = list(track_ids)
        for track_id in gone:
            self._remove(track_id, 0)
        return gone

    def _is_bare(self, track: Track) -> bool:
        return track.n_voxels < self.config.lifting.min_cells // 2

    def _remove(self, gone: int, survivor: int) -> None:
        del self.tracks[gone]
        self._index.drop(gone)
        self._consensus.replace(gone, survivor)


def _born_masks(decisions: Iterable[Decision], detections: Sequence[Detection]) -> dict[int, int]:
    """The mask of each track that was born, by track."""
    return {d.track_id: detections[d.detection].mask for d in decisions if d.outcome == "born"}
