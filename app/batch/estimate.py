"""What a scene will need, by its recording: first by rules of thumb, then by what finished scenes took."""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from app.engines.task import Needs, Outcome
from app.settings.run_config import RunConfig

# Rules of thumb until a scene is finished. The three processes of `razer run` had 0.9 GB in a small room with the
# simulator's models; what 2D models and a growing map take beyond that is guessed, and rather too much than too little.
_BASE_MB, _FRAME_MB, _AT_VOXEL_M = 2000.0, 1.0, 0.02
_BASE_S, _FRAME_S = 10.0, 0.25
_FRAME_BYTES = 400_000  # colour and depth in a .sens or a bag
_MARGIN = 1.2  # of memory, over what finished scenes took
_STEP_MB = 256.0  # few kinds of needs are scheduled faster than many
_MORE = 2.0  # of memory, after it ran out


@dataclass(frozen=True)
class RecordingSize:
    """Frames that will be mapped, and bytes of the whole recording."""

    n_frames: int
    n_bytes: int

    @classmethod
    def of(cls, files: Mapping[str, int], config: RunConfig) -> RecordingSize:
        """Of files with their bytes; the frames are those of the most numerous kind of file in one folder."""
        kinds = Counter((str(path.parent), "".join(path.suffixes[-2:])) for path in map(PurePosixPath, files))
        n_bytes = sum(files.values())
        n_files = max(kinds.values(), default=0)
        n_recorded = n_files if n_files > 2 else max(1, n_bytes // _FRAME_BYTES)
        chosen = len(range(config.input.start, min(config.input.end or n_recorded, n_recorded), config.input.stride))
        return cls(max(1, min(chosen, config.input.max_frames or chosen)), n_bytes)


@dataclass
class Estimator:
    """What scenes need. `learn` makes it better; `cpus`, which is learnt too where it may be, and `gpus` are what each
    of them is given."""

    voxel_size_m: float
    cpus: float
    gpus: float
    learns_cpus: bool = True
    _seconds: list[float] = field(default_factory=list)
    _memory: list[float] = field(default_factory=list)
    _busy: list[float] = field(default_factory=list)

    def seconds(self, size: RecordingSize) -> float:
        """How long a scene will take."""
        return self._rule_s(size) * (statistics.median(self._seconds) if self._seconds else 1.0)

    def needs(self, size: RecordingSize, n_short_of_memory: int = 0) -> Needs:
        """What a scene asks for, of which memory ran out so many times."""
        share = max(self._memory) * _MARGIN if self._memory else 1.0
        memory_mb = self._rule_mb(size) * share * _MORE**n_short_of_memory
        return Needs(self._cpus(), _STEP_MB * -(-memory_mb // _STEP_MB), self.gpus)

    def learn(self, size: RecordingSize, outcome: Outcome) -> None:
        """Take in what a finished scene took."""
        self._seconds.append(outcome.seconds / self._rule_s(size))
        self._memory.append(outcome.peak_mb / self._rule_mb(size))
        self._busy.append(outcome.cpu_s / max(outcome.seconds, 1e-3))

    def _cpus(self) -> float:
        """In halves, and at least one: where cores were short, runs were not as busy as they would be."""
        if not self._busy or not self.learns_cpus:
            return self.cpus
        return max(1.0, min(math.ceil(2 * statistics.median(self._busy)) / 2, self.cpus))

    def _rule_s(self, size: RecordingSize) -> float:
        return _BASE_S + _FRAME_S * size.n_frames

    def _rule_mb(self, size: RecordingSize) -> float:
        """A map is a surface: as many more voxels as there are in an area."""
        return _BASE_MB + _FRAME_MB * size.n_frames * (_AT_VOXEL_M / self.voxel_size_m) ** 2
