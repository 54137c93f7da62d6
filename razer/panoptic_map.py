"""The result: instances with boxes and embeddings, and the labelled surface (RAZER section IV-H)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray, Int32Array
from razer.errors import BadInput
from razer.map_object import Answer, Hit, MapObject
from razer.query.embedding_table import EmbeddingTable
from razer.query.instance_names import InstanceNames, NameChances
from razer.query.kinds import NameSet
from razer.query.naming import name_log_shares, ranked_names, set_shares
from razer.query.part_answers import better_parts
from razer.query.ranking import PRESENT, TextRanking, image_scores
from razer.query.text_queries import TextQueryEncoder
from razer.query.vote_table import NameList
from razer.storage.map_folder import SavedParts, save_map
from razer.tracking.parts.frozen_parts import frozen, frozen_parts, parts_as_instances
from razer.tracking.parts.part_surface import PartSurface
from razer.tracking.track import Track
from razer.volume.mesh_extraction import LabelledMesh
from razer.volume.voxel_map import VoxelMap


@dataclass(frozen=True)
class PanopticMap:
    """Objects by id, the mesh whose vertices bear their ids, and what encodes the texts they are queried by.

    up (3,): the world's upward direction, where it is known; stamps: seconds of frames by index; config_text: the
    settings that it was made with, as TOML; open_volume: what gives its voxel volume; parts: those of the objects, by
    id, with ids above all of theirs; vertex_parts (V,): the part that each vertex is of, 0 = none, None without any."""

    objects: tuple[MapObject, ...]
    mesh: LabelledMesh
    text_queries: TextQueryEncoder | None = None
    up: Float64Array | None = None
    stamps: Mapping[int, float] = field(default_factory=dict)
    config_text: str = ""
    open_volume: Callable[[], VoxelMap] | None = field(default=None, repr=False, compare=False)
    parts: tuple[MapObject, ...] = ()
    vertex_parts: Int32Array | None = None

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

    def query(self, text: str, threshold: float = PRESENT) -> Answer:
        """The instances that a text means (RAZER section IV-I). Where only names are known, kinds, purposes and
        enumerations ("furniture", "something to sit on", "cups and plates") stand for their names, unless something is
        there of exactly that name. A part is an answer where it fits better than its whole, but to no kind. Raises
        BadInput where the embedder cannot tell."""
        queries = self._text_queries()
        meaning = queries.meaning(text)
        if meaning is None or (queries.knows(text) and self._is_there(text)):
            queries.query_vector(text)  # tells of kinds, where the text means nothing
            return self._query_text(text, threshold)
        return self._query_names(meaning, threshold)

    def _query_text(self, text: str, threshold: float) -> Answer:
        """The instances that a text means."""
        scores, chances = self._text_scores(text)
        rows = _above(scores, threshold)
        answer = self._answer(scores, rows, threshold, self._guesses(rows))
        if chances is not None:
            hits = zip(answer.hits, rows.tolist(), strict=True)
            answer = replace(answer, hits=tuple(replace(hit, runner_up=chances.runner_up(row)) for hit, row in hits))
        return answer if not self.parts else self._with_parts_of_text(answer, text, scores)

    def _with_parts_of_text(self, answer: Answer, text: str, scores: Float64Array) -> Answer:
        """The same with parts that a text means rather than their wholes, which have `scores` (M,): whether by what was
        said of a whole or by its embeddings, as of parts nothing was said."""
        vector = self.text_vectors([text])
        of_wholes = np.maximum(scores, self.text_ranking.scores(vector)[:, 0])
        ranking = TextRanking(self.part_table, self._text_queries().negatives, self.embedding_table)
        return self._with_parts(answer, ranking.scores(vector)[:, 0], of_wholes)

    def _text_scores(self, text: str) -> tuple[Float64Array, NameChances | None]:
        """The probability (M,) that each instance is what a text means, by what was said of it where anything was and
        the text is a name, else by its embeddings alone; and all that competed, None where votes do not bear on it."""
        ranking = self.text_ranking
        if not len(self.embedding_table):
            return np.zeros(0), None
        scores = ranking.scores(self.text_vectors([text]))[:, 0]
        chances = self.instance_names.asked(text)
        if chances is not None:
            scores = np.where(chances.has_votes, chances.probabilities[:, 0], scores)
        return scores, chances

    def _with_parts(self, answer: Answer, scores: Float64Array, of_wholes: Float64Array) -> Answer:
        """An answer with the parts that fit better than their wholes, by the scores of `part_table` and of
        `embedding_table`."""
        part_by_id = {part.id: part for part in self.parts}
        parts = [part_by_id[int(i)] for i in self.part_table.ids]
        score_of = dict(zip(self.embedding_table.ids.tolist(), of_wholes.tolist(), strict=True))
        wholes = np.array([score_of.get(part.part_of, 0.0) for part in parts])
        rows = better_parts(scores, wholes, answer.threshold)
        hits = [Hit(parts[row], float(scores[row]), parts[row].class_name) for row in rows.tolist()]
        return replace(answer, hits=tuple(sorted([*answer.hits, *hits], key=lambda hit: -hit.score)))

    def _is_there(self, name: str) -> bool:
        return bool(self._text_scores(name)[0].max(initial=0.0) >= PRESENT)

    def _query_names(self, meaning: NameSet, threshold: float) -> Answer:
        """The instances whose name is one of a set."""
        choices, members = self._text_queries().choices, meaning.rows
        ranking = self.text_ranking
        if not len(self.embedding_table):
            return Answer((), threshold)
        # What is like no name at all is as much like each of them, and so like most sets of a table of few names.
        present = ranking.set_scores(choices.vectors[members])
        scores = np.minimum(set_shares(self.embedding_table, choices.vectors, members), present)
        best = name_log_shares(self.embedding_table, choices.vectors)[:, members]
        chances = self.instance_names.asked_any(NameList([choices.names[i] for i in members], choices.vectors[members]))
        if chances is not None:
            voted = chances.has_votes
            scores = np.where(voted, chances.probabilities.sum(axis=1).clip(max=1), scores)
            best = np.where(voted[:, None], chances.probabilities, best)
        rows = _above(scores, threshold)
        best = best[rows].argmax(axis=1)
        answer = self._answer(scores, rows, threshold, self._guesses(rows))
        hits = [
            replace(hit, through=choices.names[members[number]], kind=meaning.kinds[number])
            for hit, number in zip(answer.hits, best, strict=True)
        ]
        return Answer(tuple(hits), threshold)

    def query_image(self, vector: Float32Array, threshold: float = PRESENT) -> Answer:
        """The instances that look like a vector (D,) of unit length, as of `ImageEncoder.embed_region`; raises BadInput
        for one of another embedder."""
        self._check(len(vector))
        if not len(self.embedding_table):
            return Answer((), threshold)
        scores = image_scores(self.embedding_table, vector)
        rows = _above(scores, threshold)
        answer = self._answer(scores, rows, threshold, [None] * len(rows))
        if not self.parts:
            return answer
        return self._with_parts(answer, image_scores(self.part_table, vector, self.embedding_table), scores)

    def name_probabilities(self, names: Sequence[str]) -> Float64Array:
        """The probability (M, N) that each instance of `embedding_table` is called each of N names, which add up to 1:
        by what the segmenter called it, from how many sides, and by its embeddings. Whatever gives instances names asks
        here. Raises BadInput for a name that a table lacks, and for vectors of another embedder."""
        self._check(self.text_vectors(names[:1]).shape[1])
        return np.minimum(np.exp(self.instance_names.log_probabilities(names)), 1.0)

    @cached_property
    def instance_names(self) -> InstanceNames:
        """What the instances of `embedding_table` may be called; raises BadInput where no embedder is known."""
        votes = {o.id: o.class_votes for o in self.objects}
        of_rows = [votes[i] for i in self.embedding_table.ids.tolist()]
        return InstanceNames(self.embedding_table, of_rows, self._text_queries())

    def _guesses(self, rows: IndexArray) -> list[str]:
        """The negative prompt that suits each of some instances best, by their rows in `embedding_table`."""
        negatives = self._text_queries().negatives
        best = ranked_names(self.embedding_table, negatives.vectors, rows)
        return [negatives.names[number] for number in best[:, 0]]

    @cached_property
    def embedding_table(self) -> EmbeddingTable:
        """The embeddings of all objects."""
        return EmbeddingTable.of({o.id: (o.embeddings, o.weights) for o in self.objects})

    @cached_property
    def part_table(self) -> EmbeddingTable:
        """The embeddings of all parts."""
        return EmbeddingTable.of({part.id: (part.embeddings, part.weights) for part in self.parts})

    @cached_property
    def text_ranking(self) -> TextRanking:
        """The objects, ready for texts; raises BadInput where the embedder cannot tell."""
        negatives = self._text_queries().negatives
        self._check(negatives.vectors.shape[1])
        return TextRanking(self.embedding_table, negatives)

    def text_vectors(self, texts: Sequence[str]) -> Float32Array:
        """Unit vectors (N, D) of texts."""
        return self._text_queries().vectors(texts)

    def _text_queries(self) -> TextQueryEncoder:
        if self.text_queries is None:
            raise BadInput("no embedder is known for this map, so that it cannot be queried by text")
        return self.text_queries

    def _check(self, dimension: int) -> None:
        own = self.embedding_table.vectors.shape[1]
        if len(self.embedding_table) and own != dimension:
            raise BadInput(
                f"the embedder makes vectors of {dimension} numbers, but those of this map have {own}: "
                "name the embedder that made them with --embedder and --set"
            )

    def _answer(
        self, scores: Float64Array, rows: IndexArray, threshold: float, guesses: Sequence[str | None]
    ) -> Answer:
        known = {o.id: o for o in self.objects}
        matches = [known[int(i)] for i in self.embedding_table.ids[rows]]
        hits = [
            Hit(o, float(score), o.class_name or guess)
            for o, score, guess in zip(matches, scores[rows], guesses, strict=True)
        ]
        return Answer(tuple(hits), threshold)


def _above(scores: Float64Array, threshold: float) -> IndexArray:
    """Rows of the scores (M,) that reach a threshold, the best first."""
    order = np.argsort(-scores, kind="stable")
    return order[scores[order] >= threshold]
