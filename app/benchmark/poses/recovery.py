"""Recovery: how many frames a lost camera takes to know where it is, once it sees what it saw before."""

from __future__ import annotations

from collections.abc import Mapping

from app.benchmark.poses.known_view import KnownCells
from app.benchmark.poses.motion_error import leads_astray
from razer.arrays import Int64Array, Pose

MIN_KNOWN = 0.3  # share of the view


class RecoveryWatch:
    """Looks on as frames are located, and counts for each time that the camera was lost.

    A camera is lost from a frame without a pose on, until it gets one from which the last one before is as far as it
    truly is: a pose at another place is no recovery. What was seen while it was lost is not known yet.
    """

    def __init__(self) -> None:
        self.frames_to_recover: list[int] = []  # of each time that it was found again
        self.waited = 0  # frames since what is seen is known again, if the camera is lost now
        self._known, self._unknown = KnownCells(), list[Int64Array]()
        self._last: int | None = None  # frame that was located
        self._is_lost = False

    def see(self, frame: int, cells: Int64Array | None, poses: Mapping[int, Pose], truth: Mapping[int, Pose]) -> None:
        """Take in one frame, as soon as it was located or not, by its index, and the cells that it shows, None = none
        as the camera is blind; with the poses so far as known now, its own among them if it was located, and the true
        ones of all frames that show something."""
        if cells is not None and frame in poses and not self._is_astray(frame, poses, truth):
            self._found(frame, cells)
            return
        self._is_lost = True
        if cells is None:
            return
        self._unknown.append(cells)
        self.waited += self.waited > 0 or self._known.share(cells) >= MIN_KNOWN

    def _is_astray(self, frame: int, poses: Mapping[int, Pose], truth: Mapping[int, Pose]) -> bool:
        before = self._last
        return self._is_lost and before is not None and before in poses and leads_astray(poses, truth, before, frame)

    def _found(self, frame: int, cells: Int64Array) -> None:
        if self._is_lost and self._last is not None:
            self.frames_to_recover.append(self.waited)
        for each in (*self._unknown, cells):
            self._known.add(each)
        self._unknown.clear()
        self._last, self._is_lost, self.waited = frame, False, 0

    @property
    def longest(self) -> int | None:
        """The most frames that a recovery took, 0 if the camera was never lost; None if it was not found again
        although it saw what is known."""
        return None if self.waited else max(self.frames_to_recover, default=0)
