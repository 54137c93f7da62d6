"""Checkpoints of a whole run: the states of its two processes at one moment, written between two frames."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass
from functools import cached_property
from hashlib import blake2b
from pathlib import Path
from time import perf_counter

from rich.console import Console

from app.checkpoints.ongoing_run import OngoingRun
from app.checkpoints.schedule import CheckpointSchedule
from app.frames.frame_packet import FramePacket, StateSaved
from app.frames.packet_stream import StreamCheckpoints
from app.stored_state.checkpoint import Checkpoint
from app.stored_state.pose_checkpoints import PoseCheckpoints
from app.stored_state.saved_state import SavedState
from app.stored_state.state_files import StateWriter
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput, UnusableFrame
from razer.stages import stage
from slam.config import SlamConfig

MAP = "map"


@dataclass(frozen=True)
class RunPlan:
    """What tells one run from another: the name of the recording, how many frames are `planned`, the hash of the first
    one, and the vocabulary that the instances are to be named by in the end."""

    name: str
    planned: int
    first_frame: str
    vocabulary: str | None = None

    @classmethod
    def of(cls, sequence: RgbdSequence, indices: range, vocabulary: str | None = None) -> RunPlan:
        """The plan of a run over frames of a recording."""
        return cls(sequence.name, len(indices), _hash_of(sequence, indices[0]) if indices else "", vocabulary)

    def require_same(self, checkpoint: Checkpoint) -> None:
        """Raise BadInput where a checkpoint is of other frames."""
        if (self.planned, self.first_frame) != (checkpoint.planned, checkpoint.first_frame):
            raise BadInput(f"{self.name} has changed since the run was begun: it cannot be resumed, start it anew")


def _hash_of(sequence: RgbdSequence, index: int) -> str:
    try:
        frame = sequence[index]
    except UnusableFrame:
        return ""
    return blake2b(frame.rgb.tobytes() + frame.depth.tobytes(), digest_size=16).hexdigest()


class RunCheckpoints:
    """Writes the checkpoints of one run into a folder, which it makes."""

    def __init__(
        self,
        folder: Path,
        plan: RunPlan,
        slam: SlamConfig | None,
        every_frames: int | None,
        console: Console,
        before: Checkpoint | None = None,
    ) -> None:
        """Args:
        folder: where they go.
        plan: of the run.
        slam: settings of the estimation of poses, None where they are given.
        every_frames: as for `CheckpointSchedule`.
        console: where it is said that one could not be written.
        before: the checkpoint that the run goes on from.
        """
        self._folder, self._plan, self._console = folder, plan, console
        self._slam, self._before = slam, before
        self._schedule = CheckpointSchedule(every_frames)
        self._failed = ""
        folder.mkdir(exist_ok=True)

    @cached_property
    def stream(self) -> StreamCheckpoints:
        """What the stream of frames has to know."""
        before = self._before
        poses = PoseCheckpoints(self._folder, self._slam, None if before is None else before.poses)
        return StreamCheckpoints(self._schedule.is_due, poses, 0 if before is None else before.n_frames)

    def saving(self, packets: Iterable[FramePacket | StateSaved], run: OngoingRun) -> Generator[FramePacket]:
        """The packets of frames; a checkpoint is written wherever the locator's state comes between them, when all
        frames before it are mapped."""
        writer = StateWriter(self._folder, MAP, run.known)
        for packet in packets:
            if isinstance(packet, StateSaved):
                self._save(packet, run, writer)
            else:
                yield packet

    def _save(self, packet: StateSaved, run: OngoingRun, writer: StateWriter) -> None:
        start_s = perf_counter()
        if packet.poses is None:
            self._warn(packet.reason)
        else:
            try:
                with run.recorder.late_frame({}), stage("checkpoint"):
                    self._write(packet.n_frames, packet.poses, run, writer)
            except OSError as error:
                self._warn(error.strerror or str(error))
        self._schedule.note_cost(packet.cost_s + perf_counter() - start_s)

    def _write(self, n_frames: int, poses: SavedState, run: OngoingRun, writer: StateWriter) -> None:
        written = run.written_timeline()  # before its state: what is remembered as logged is in the file
        saved, plan = writer.save(run.state), self._plan
        checkpoint = Checkpoint(n_frames, plan.planned, saved, poses, plan.first_frame, plan.vocabulary, written)
        checkpoint.write(self._folder)

    def _warn(self, reason: str) -> None:
        if reason != self._failed:
            self._console.print(f"note: a checkpoint could not be written ({reason}); the run goes on", soft_wrap=True)
        self._failed = reason
