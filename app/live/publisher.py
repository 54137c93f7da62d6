"""Snapshots of a growing map, taken in the run's own process, within a fixed share of its time."""

from __future__ import annotations

import pickle
import queue
import threading
from multiprocessing.connection import Connection
from time import perf_counter, thread_time

import numpy as np

from app.live.due_chunks import BLOCKS_PER_EDGE, DueChunks
from app.live.snapshot import Finished, Snapshot
from razer.detection.observed_surface import BLOCK
from razer.frame import Frame
from razer.mapper import Mapper
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import blocks_of, by_chunk
from razer.tracking.parts.frozen_parts import frozen
from razer.tracking.step_result import StepResult
from razer.volume.mesh_extraction import extract_part

TIME_SHARE = 0.02  # of the run's, at most: the process that serves takes of it, too
AIM_S = 0.04  # what one snapshot may take; a smaller one has hardly more chunks than it has overhead
_FIRST_GUESS_S = 0.005  # for a chunk
_WAITING = 2  # snapshots, for a reader that is slower


class Publisher:
    """Sends snapshots down a pipe. Nobody who reads, or reads slowly, or is gone, can hold up the run."""

    def __init__(self, pipe: Connection) -> None:
        self._waiting: queue.Queue[bytes] = queue.Queue(_WAITING)
        self._due = DueChunks()
        self._renamed: dict[int, int] = {}
        self._is_rebuilt = False
        self._up = np.zeros(3)
        self._next_s = 0.0
        self._chunk_s = _FIRST_GUESS_S
        self._is_gone = False
        threading.Thread(target=self._send, args=(pipe,), name="razer-publish", daemon=True).start()

    def show(self, frame: Frame, step: StepResult, mapper: Mapper) -> None:
        """Note what a frame changed, and send a snapshot if it is time for one."""
        self._note(frame, step)
        started_s = perf_counter()
        if self._is_gone or started_s < self._next_s or self._waiting.full():
            return
        self._put(self._snapshot(frame.index, mapper))
        done_s = perf_counter()
        self._next_s = done_s + (done_s - started_s) / TIME_SHARE

    def finish(self, finished: Finished) -> None:
        """Send that the run is over, after all that waits; waits for it itself, as there is nothing else to do."""
        if not self._is_gone:
            self._waiting.put(pickle.dumps(finished), timeout=60)

    def _note(self, frame: Frame, step: StepResult) -> None:
        self._due.observe(step.changed_blocks)
        self._renamed |= dict.fromkeys(step.pruned, 0) | dict(step.fused)
        self._up -= frame.pose[:3, 1]
        if step.rebuilt:
            self._due.all_changed()
            self._is_rebuilt = True

    def _snapshot(self, frame_index: int, mapper: Mapper) -> Snapshot:
        chunks = self._due.take(max(int(AIM_S / self._chunk_s), 4))
        started_s = thread_time()  # a busy machine makes a snapshot late, not small
        mesh = extract_part(mapper.voxels, blocks_of(chunks, BLOCKS_PER_EDGE))
        parts = by_chunk(mesh, mapper.voxels.settings.voxel_size_m * BLOCK * BLOCKS_PER_EDGE)
        if chunks:
            measured_s = (thread_time() - started_s) / len(chunks)
            self._chunk_s = 0.7 * self._chunk_s + 0.3 * measured_s
        objects = tuple(frozen(track, 0) for track in mapper.tracks if track.confirmed)
        told = {chunk: parts.get(chunk, LabelledMesh.empty()) for chunk in chunks}  # an empty one is to vanish
        snapshot = Snapshot(frame_index, objects, told, self._renamed, self._up.copy(), self._is_rebuilt)
        self._renamed, self._is_rebuilt = {}, False
        return snapshot

    def _put(self, snapshot: Snapshot) -> None:
        self._waiting.put_nowait(pickle.dumps(snapshot, pickle.HIGHEST_PROTOCOL))

    def _send(self, pipe: Connection) -> None:
        try:
            while True:
                pipe.send_bytes(self._waiting.get())
        except OSError:  # who read is gone
            self._is_gone = True
            while True:
                self._waiting.get()
