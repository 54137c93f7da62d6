"""The mesh of a growing map in chunks, each with the revision that it changed in last."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.live.snapshot import Snapshot
from razer.arrays import Int32Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk


class GrowingMesh:
    """Takes in snapshots; not safe from several threads."""

    def __init__(self) -> None:
        self.revision = 0
        self._chunks: dict[Chunk, tuple[int, LabelledMesh]] = {}

    def take(self, snapshot: Snapshot) -> None:
        """Bring the mesh up to a snapshot, which is the next revision."""
        self.revision += 1
        if snapshot.renamed:
            self._rename(snapshot.renamed)
        self._chunks.update((chunk, (self.revision, mesh)) for chunk, mesh in snapshot.chunks.items())

    def changes(self, since: int) -> dict[Chunk, LabelledMesh]:
        """The chunks that changed after a revision, some of which may be empty by now; all of them for 0."""
        return {chunk: mesh for chunk, (revision, mesh) in self._chunks.items() if revision > since}

    def whole(self, known: Int32Array) -> LabelledMesh:
        """All chunks as one mesh, whose vertices are nobody's but for `known` ids (K,)."""
        meshes = [mesh for _, mesh in self._chunks.values()]
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
        triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts[:-1], strict=True)]
        parts = [LabelledMesh.empty(), *meshes]
        instances = np.concatenate([part.instances for part in parts])
        return LabelledMesh(
            np.concatenate([part.vertices for part in parts]),
            np.concatenate([part.colors for part in parts]),
            np.where(np.isin(instances, known), instances, 0).astype(np.int32),
            np.concatenate([parts[0].triangles, *triangles]).astype(np.int32),
        )

    def _rename(self, renamed: Mapping[int, int]) -> None:
        final = {gone: _followed(gone, renamed) for gone in renamed}
        gone = np.array(sorted(final), np.int32)
        heirs = np.array([final[i] for i in gone.tolist()], np.int32)
        for chunk, (_, mesh) in self._chunks.items():
            place = np.searchsorted(gone, mesh.instances).clip(max=len(gone) - 1)
            is_gone = gone[place] == mesh.instances
            if is_gone.any():
                instances = np.where(is_gone, heirs[place], mesh.instances).astype(np.int32)
                renewed = LabelledMesh(mesh.vertices, mesh.colors, instances, mesh.triangles)
                self._chunks[chunk] = self.revision, renewed


def _followed(gone: int, renamed: Mapping[int, int]) -> int:
    seen = {gone}
    while gone in renamed and renamed[gone] not in seen:
        gone = renamed[gone]
        seen.add(gone)
    return gone
