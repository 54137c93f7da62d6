"""A run between two frames: all that it has made so far, as it is saved and restored."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from app.checkpoints.run_state import RunState, known_run
from app.frames.cameras.color_registration import ColorRegistration
from app.frames.frame_accounting import FrameAccounting
from app.profiling.recorder import Recorder
from app.stored_state.checkpoint import Checkpoint
from app.stored_state.state_codec import KnownObjects
from app.stored_state.state_files import load_state
from app.timeline.null_timeline import NullTimeline
from razer.mapper import Mapper

if TYPE_CHECKING:
    from app.stored_state.written_log import WrittenLog
    from app.timeline.rerun_timeline import Timeline


@dataclass
class OngoingRun:
    """The method, what became of the frames, their figures, where they are shown, and how colour lies to depth;
    `resumed_at`, after how many frames the run went on from a checkpoint, each time that it did."""

    mapper: Mapper
    accounting: FrameAccounting
    recorder: Recorder
    timeline: Timeline | NullTimeline
    registration: ColorRegistration
    resumed_at: tuple[int, ...] = ()

    @cached_property
    def known(self) -> KnownObjects:
        """What its state may speak of."""
        return known_run(self.mapper.config, self.timeline)

    @property
    def state(self) -> RunState:
        """All of it that changes."""
        timeline = None if isinstance(self.timeline, NullTimeline) else self.timeline.state
        figures, resumed_at = self.recorder.state, self.resumed_at
        return RunState(self.mapper.state, self.accounting, figures, self.registration, timeline, resumed_at)

    def written_timeline(self) -> WrittenLog | None:
        """What of the timeline is in its file by now; None where there is none, or it cannot be written."""
        return None if isinstance(self.timeline, NullTimeline) else self.timeline.written()

    def restore(self, folder: Path, checkpoint: Checkpoint) -> None:
        """Become what a checkpoint holds; raises BadInput where it cannot be used."""
        state: RunState = load_state(folder, checkpoint.map, self.known)
        self.mapper.state, self.accounting, self.recorder.state = state.mapper, state.accounting, state.recorder
        self.registration, self.resumed_at = state.registration, (*state.resumed_at, checkpoint.n_frames)
        if not isinstance(self.timeline, NullTimeline) and state.timeline is not None:
            self.timeline.state = state.timeline
