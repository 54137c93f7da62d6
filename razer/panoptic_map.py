"""The result: instances with boxes and embeddings, and the labelled surface (RAZER section IV-H)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from razer.arrays import Float32Array, Float64Array, Int32Array
from razer.errors import BadInput
from razer.map_object import Answer, MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.query.embedding_table import EmbeddingTable
from razer.query.instance_names import InstanceNames
from razer.query.map_queries import MapQueries
from razer.query.ranking import PRESENT, TextRanking
from razer.query.text_queries import TextQueryEncoder
from razer.storage.map_folder import SavedParts, save_map
from razer.tracking.parts.frozen_parts import frozen, frozen_parts, parts_as_instances

if TYPE_CHECKING:  # they bring Open3D and torch along, which takes seconds: a saved map is asked without
    from razer.tracking.parts.part_surface import PartSurface
    from razer.tracking.track import Track
    from razer.volume.voxel_map import VoxelMap

VIEWERS = "razer.viewers"  # entry points: what is installed that shows a map's folder to people


@dataclass(frozen=True)
class PanopticMap:
    """Objects by id, the mesh whose vertices bear their ids, and what encodes the texts they are queried by.

    up (3,): the world's upward direction, where it is known; stamps: seconds of frames by index; config_text: the
    settings that it was made with, as TOML; open_volume: what gives its voxel volume; parts: those of the objects, by
    id, with ids above all of theirs; vertex_parts (V,): the part that each vertex is of, 0 = none, None without any;
    folder: where it was opened, None for a map in memory; epoch: how many entries the log of its hand edits has;
    edit_problems: which of them could not be applied and why, a line each."""

    objects: tuple[MapObject, ...]
    mesh: LabelledMesh
    text_queries: TextQueryEncoder | None = None
    up: Float64Array | None = None
    stamps: Mapping[int, float] = field(default_factory=dict)
    config_text: str = ""
    open_volume: Callable[[], VoxelMap] | None = field(default=None, repr=False, compare=False)
    parts: tuple[MapObject, ...] = ()
    vertex_parts: Int32Array | None = None
    folder: Path | None = None
    epoch: int = 0
    edit_problems: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        tracks: Sequence[Track],
        mesh: LabelledMesh,
        text_queries: TextQueryEncoder | None = None,
        surfaces: Sequence[PartSurface] = (),
        voxel_size_m: float = 0.02,
    ) -> PanopticMap:
        """Freeze tracks, the surfaces of their parts, and mesh; vertices of ids that are no object become nobody's."""
        known = np.array(sorted(track.id for track in tracks), dtype=np.int32)
        instances = np.where(np.isin(mesh.instances, known), mesh.instances, 0).astype(np.int32)
        counts = np.bincount(instances, minlength=1)
        objects = [frozen(t, int(counts[t.id]) if t.id < len(counts) else 0) for t in tracks]
        mesh = LabelledMesh(mesh.vertices, mesh.colors, instances, mesh.triangles)
        panoptic = cls(tuple(sorted(objects, key=lambda o: o.id)), mesh, text_queries)
        parts, labels = frozen_parts(surfaces, mesh, int(known.max(initial=0)), voxel_size_m)
        return replace(panoptic, parts=parts, vertex_parts=labels) if parts else panoptic

    def in_parts(self) -> PanopticMap:
        """The same at the granularity of parts: each is an instance, beside what is left of the wholes."""
        if self.vertex_parts is None:
            return self
        objects, mesh = parts_as_instances(self.objects, self.parts, self.mesh, self.vertex_parts)
        return replace(self, objects=objects, mesh=mesh, parts=(), vertex_parts=None)

    def parts_of(self, object_id: int) -> tuple[MapObject, ...]:
        """The parts of an instance."""
        return tuple(part for part in self.parts if part.part_of == object_id)

    def mesh_of(self, shown: Collection[int]) -> LabelledMesh:
        """The mesh with some objects shown, by their ids: vertices of a part among them bear its id."""
        if self.vertex_parts is None:
            return self.mesh
        is_shown = np.isin(self.vertex_parts, [part.id for part in self.parts if part.id in shown])
        instances = np.where(is_shown, self.vertex_parts, self.mesh.instances).astype(np.int32)
        return replace(self.mesh, instances=instances)

    @cached_property
    def volume(self) -> VoxelMap:
        """The voxel volume that the mesh was taken from; raises BadInput where it is not at hand."""
        if self.open_volume is None:
            raise BadInput("the volume of this map is not at hand")
        return self.open_volume()

    @property
    def up_or_z(self) -> Float64Array:
        """The upward direction (3,); z where it is not known."""
        return np.array([0.0, 0.0, 1.0]) if self.up is None else self.up

    def save(self, folder: str | Path) -> None:
        """Write instances.json, mesh.ply, embeddings.npz, config.toml and, where there are parts, parts.npz, where the
        volume is at hand, map.npz; `razer.load_map` opens them. Raises BadInput if the folder holds something else, or
        cannot be written."""
        volume = None if self.open_volume is None else self.volume
        parts = self.parts, self.vertex_parts
        saved = SavedParts(self.objects, self.mesh, self.up, self.stamps, self.config_text, volume, *parts)
        save_map(Path(folder), saved)

    def show(self) -> Path:
        """Open the map in the browser, as a page of one file that needs no network; returns that file. The program
        `razer` draws it. Raises BadInput for a map in memory, and where the program is not installed."""
        if self.folder is None:
            raise BadInput("this map is in memory only: save it, and show what razer.load_map opens")
        for viewer in entry_points(group=VIEWERS):
            page: Path = viewer.load()(self.folder)
            return page
        raise BadInput(f"nothing is installed that shows maps (entry points {VIEWERS}): pip install razer anew")

    def query(self, text: str, threshold: float = PRESENT) -> Answer:
        """The instances that a text means (RAZER section IV-I). Where only names are known, kinds, purposes and
        enumerations ("furniture", "something to sit on", "cups and plates") stand for their names, unless something is
        there of exactly that name. A part is an answer where it fits better than its whole, but to no kind. What people
        named by hand is found by that name. Raises BadInput where the embedder cannot tell."""
        return self.queries.by_text(text, threshold)

    def query_image(self, vector: Float32Array, threshold: float = PRESENT) -> Answer:
        """The instances that look like a vector (D,) of unit length, as of `ImageEncoder.embed_region`; raises BadInput
        for one of another embedder."""
        return self.queries.by_image(vector, threshold)

    def name_probabilities(self, names: Sequence[str]) -> Float64Array:
        """The probability (M, N) that each instance of `embedding_table` is called each of N names, which add up to 1:
        by what the segmenter called it, from how many sides, and by its embeddings; of what people named by hand by
        that name alone. Whatever gives instances names asks here. Raises BadInput for a name that a table lacks, and
        for vectors of another embedder."""
        return self.queries.name_probabilities(names)

    @cached_property
    def queries(self) -> MapQueries:
        """What answers, with what it keeps from one query to the next."""
        return MapQueries(self.objects, self.parts, self.text_queries)

    @property
    def instance_names(self) -> InstanceNames:
        """What the instances of `embedding_table` may be called; raises BadInput where no embedder is known."""
        return self.queries.instance_names

    @property
    def embedding_table(self) -> EmbeddingTable:
        """The embeddings of all objects."""
        return self.queries.embedding_table

    @property
    def text_ranking(self) -> TextRanking:
        """The objects, ready for texts; raises BadInput where the embedder cannot tell."""
        return self.queries.text_ranking

    def text_vectors(self, texts: Sequence[str]) -> Float32Array:
        """Unit vectors (N, D) of texts; raises BadInput where no embedder is known."""
        return self.queries.known_encoder.vectors(texts)
