"""The map while it grows: its surface by chunks, logged where enough has changed, and boxes of what was seen of each
track."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from app.render.mesh_decimation import cluster_vertices
from app.timeline import entities
from app.timeline.config import TimelineConfig
from app.timeline.map_chunks import BLOCKS_PER_EDGE, ChunkSchedule
from app.timeline.recording.rerun_log import RerunLog
from app.timeline.surface_colors import lightly_tinted
from razer.arrays import Float32Array, Int32Array
from razer.boxes.oriented_box import SURFACE_TRIM, OrientedBox
from razer.detection.observed_surface import BLOCK
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk, blocks_of, by_chunk
from razer.tracking.track import Track
from razer.volume.mesh_extraction import extract_part
from razer.volume.voxel_map import VoxelMap

FEWEST_POINTS = 4  # of surface that has a box


class GrowingMap:
    """Logs the surface chunk by chunk, and keeps what it logged."""

    def __init__(self, log: RerunLog, config: TimelineConfig) -> None:
        self._log = log
        self._config = config
        self._schedule = ChunkSchedule(config.surface_growth)
        self._drawn: dict[Chunk, LabelledMesh] = {}

    def observe(self, block_keys: Int32Array, *, rebuilt: bool) -> None:
        """Note the blocks (M, 3) that a frame changed, and whether the whole map moved."""
        self._schedule.observe(block_keys)
        if rebuilt:
            self._schedule.invalidate()

    def draw(self, voxels: VoxelMap) -> None:
        """Log the chunks that changed enough since they were last logged."""
        due = self._schedule.take_due()
        if not due:
            return
        mesh = extract_part(voxels, blocks_of(due, BLOCKS_PER_EDGE))
        edge_m = voxels.settings.voxel_size_m * BLOCK * BLOCKS_PER_EDGE
        parts = by_chunk(cluster_vertices(mesh, self._config.surface_cell_m, edge_m), edge_m)
        for chunk in due:
            entity = f"{entities.GROWING}/{chunk.x}_{chunk.y}_{chunk.z}"
            part = parts.get(chunk)
            if part is not None:
                self._log.mesh(entity, part, lightly_tinted(part))
                self._drawn[chunk] = part
            elif self._drawn.pop(chunk, None) is not None:  # all of it was carved away
                self._log.clear(entity, recursive=False)

    def drawn(self) -> tuple[Float32Array, Int32Array]:
        """The points (N, 3) of the surface as last logged, and the tracks (N,) that they belonged to."""
        none = np.zeros((0, 3), np.float32), np.zeros(0, np.int32)
        parts = [none, *((part.vertices, part.instances) for part in self._drawn.values())]
        positions, instances = zip(*parts, strict=True)
        return np.concatenate(positions), np.concatenate(instances)

    def seen_boxes(self, tracks: Iterable[Track]) -> dict[int, OrientedBox]:
        """The box of each track, no larger than the surface of it that was logged; none where there is none yet."""
        positions, instances = self.drawn()
        order = np.argsort(instances, kind="stable")
        ids, first = np.unique(instances[order], return_index=True)
        # Where there is nothing, splitting it gives one empty part all the same.
        points = dict(zip(ids.tolist(), np.split(positions[order], first[1:]), strict=False))
        boxes = {track.id: _within(track.box, points.get(track.id)) for track in tracks}
        return {track_id: box for track_id, box in boxes.items() if box is not None}


def _within(box: OrientedBox, points: Float32Array | None) -> OrientedBox | None:
    """The part of a box that holds points (N, 3), but for the outermost hundredth of them."""
    if points is None or len(points) < FEWEST_POINTS:
        return None
    seen = OrientedBox.around(points.astype(np.float64), box.rotation, SURFACE_TRIM)
    middle, own = (b.center @ box.rotation for b in (seen, box))
    low = np.maximum(middle - seen.extent / 2, own - box.extent / 2)
    high = np.minimum(middle + seen.extent / 2, own + box.extent / 2)
    if (high <= low).any():
        return None
    return OrientedBox(box.rotation @ ((low + high) / 2), box.rotation, high - low)
