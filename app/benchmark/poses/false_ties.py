"""False ties: edges of a pose graph, and merges of submaps, that tie places together which lie elsewhere in truth."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from app.benchmark.poses.motion_error import is_false
from razer.arrays import Pose
from razer.geometry import inverse
from slam.frontend.keyframes import Keyframe
from slam.pose_edge import PoseEdge


def count_false_edges(edges: Iterable[PoseEdge], frames: Sequence[int], truth: Mapping[int, Pose]) -> int:
    """How many edges measure a motion that is false.

    Args:
        edges: of the pose graph.
        frames: the index of each keyframe's frame, by the keyframe's number.
        truth: true poses by frame.
    """
    true = [truth[frame] for frame in frames]
    return sum(is_false(edge.a_from_b, inverse(true[edge.a]) @ true[edge.b]) for edge in edges)


class MergeWatch:
    """Looks on as submaps are merged, and counts merges that put a submap where it is not."""

    def __init__(self) -> None:
        self.n_false = 0
        self._submaps: list[int] = []  # of each keyframe, when it was looked at last

    def see(self, keyframes: Sequence[Keyframe], truth: Mapping[int, Pose]) -> None:
        """Compare the submaps of all keyframes, in the order of their numbers, with those that they had before; `truth`
        holds true poses by frame."""
        now = [keyframe.submap for keyframe in keyframes]
        before, self._submaps = self._submaps, now
        if now[: len(before)] == before:
            return
        parts: dict[int, dict[int, list[Keyframe]]] = {}
        for was, is_in, keyframe in zip(before, now, keyframes, strict=False):
            parts.setdefault(is_in, {}).setdefault(was, []).append(keyframe)
        for merged in parts.values():
            one, *others = sorted(merged.values(), key=len, reverse=True)
            self.n_false += sum(_is_false_merge(one, other, truth) for other in others)


def _is_false_merge(one: Sequence[Keyframe], other: Sequence[Keyframe], truth: Mapping[int, Pose]) -> bool:
    """Whether no two keyframes of the two lie to each other as they do in truth: those far from where the two were tied
    together have drifted, and count as little as they can."""
    return all(
        is_false(inverse(a.world_from_camera) @ b.world_from_camera, inverse(truth[a.view.index]) @ truth[b.view.index])
        for a in one
        for b in other
    )
