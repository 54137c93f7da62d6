"""Classified run: its files, its JSON and its table."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from json import dumps
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from app.console.streams import result_console
from app.query.queryable_map import QueryableMap
from app.render.glb import NodeFacts, write_glb
from app.render.palette import instance_colors
from app.run_folder import run_folder as names
from razer.files import read_json
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.semantics.labelling import Label, Segment, segment_ids, segments
from razer.semantics.scene_graph import scene_graph
from razer.storage.atomic_files import replace_files
from razer.storage.ply import VERTEX, vertex_rows, write_ply

FORMAT = 1
PANOPTIC_VERTEX = np.dtype([*VERTEX.descr, ("class", "<i4")])


@dataclass(frozen=True)
class LabelledRun:
    """The classes of a run's instances, and the things and stuff they make up."""

    queryable: QueryableMap
    vocabulary: str
    labels: list[Label]
    segments: list[Segment]

    @classmethod
    def of(cls, queryable: QueryableMap, vocabulary: str, labels: list[Label]) -> LabelledRun:
        """From one label for each instance; stuff of one class is merged into one segment."""
        return cls(queryable, vocabulary, labels, segments(labels))

    def write(self) -> None:
        """Write all files anew; they take their places once all are complete, instances.json as the last."""
        folder, mesh = self.queryable.folder, self._mesh()
        graph = scene_graph(self.queryable.panoptic, self.segments, self.queryable.up)
        facts = {s.id: NodeFacts(s.category.name, s.score) for s in self.segments}
        table, instances = self._document(mesh), self._instances()
        replace_files(
            {
                folder / names.PANOPTIC: lambda path: _write_json(path, table),
                folder / names.SCENE_GRAPH: lambda path: _write_json(path, graph),
                folder / names.PANOPTIC_PLY: lambda path: self._write_panoptic_ply(path, mesh),
                folder / names.MESH_GLB: lambda path: write_glb(path, mesh, self.queryable.up, facts),
                folder / names.INSTANCES: lambda path: _write_json(path, instances),
            }
        )

    def _document(self, mesh: LabelledMesh) -> dict[str, Any]:
        epoch = self.queryable.panoptic.epoch
        return {"format": FORMAT, "vocabulary": self.vocabulary, "epoch": epoch, "segments": self._table(mesh)}

    def named(self) -> PanopticMap:
        """The map with the classes given."""
        given = {label.id: label.category.name for label in self.labels}
        panoptic = self.queryable.panoptic
        objects = (o if o.is_named_by_hand else replace(o, class_name=given.get(o.id)) for o in panoptic.objects)
        return replace(panoptic, objects=tuple(objects))

    def as_json(self) -> dict[str, Any]:
        """The JSON of `razer label`."""
        instances = [
            {
                "id": label.id,
                "class": label.category.name,
                "score": round(label.score, 4),
                "runner_up": label.runner_up.name if label.runner_up else None,
                "runner_up_score": round(label.runner_up_score, 4) if label.runner_up else None,
            }
            for label in self.labels
        ]
        segments = [segment for segment in self.segments if segment.category.stuff]
        stuff = [{"id": s.id, "class": s.category.name, "instances": list(s.instances)} for s in segments]
        return {"vocabulary": self.vocabulary, "instances": instances, "stuff": stuff}

    def report(self) -> None:
        """Print the number of instances of each class, and which of them are ambiguous."""
        table = Table()
        table.add_column("class")
        table.add_column("instances", justify="right")
        table.add_column("ids")
        counts = Counter(label.category.name for label in self.labels)
        for name, count in counts.most_common():
            ids = ", ".join(str(label.id) for label in self.labels if label.category.name == name)
            table.add_row(name, str(count), ids)
        console = result_console()
        console.print(table)
        for label in self.labels:
            if label.is_ambiguous and label.runner_up is not None:
                either = (
                    f"{label.category.name} {label.score:.2f}, or {label.runner_up.name} {label.runner_up_score:.2f}"
                )
                console.print(f"{label.id} is ambiguous: {either}", soft_wrap=True)

    def _mesh(self) -> LabelledMesh:
        """The mesh whose instances are segments."""
        mesh = self.queryable.panoptic.mesh
        return LabelledMesh(mesh.vertices, mesh.colors, segment_ids(mesh, self.segments)[0], mesh.triangles)

    def _table(self, mesh: LabelledMesh) -> list[dict[str, Any]]:
        counts = Counter(mesh.instances.tolist())
        return [
            {
                "id": s.id,
                "class": s.category.name,
                "class_id": s.category.id,
                "stuff": s.category.stuff,
                "score": round(s.score, 4),
                "instances": list(s.instances),
                "n_vertices": counts[s.id],
            }
            for s in self.segments
        ]

    def _write_panoptic_ply(self, path: Path, mesh: LabelledMesh) -> None:
        categories = segment_ids(self.queryable.panoptic.mesh, self.segments)[1]
        shown = LabelledMesh(mesh.vertices, instance_colors(categories), mesh.instances, mesh.triangles)
        vertices = vertex_rows(shown, PANOPTIC_VERTEX)
        vertices["instance"], vertices["class"] = mesh.instances, categories
        write_ply(path, vertices, mesh.triangles)

    def _instances(self) -> dict[str, Any]:
        content: dict[str, Any] = read_json(self.queryable.folder / names.INSTANCES)
        given = {label.id: label.category.name for label in self.labels}
        # What people named, merged or deleted keeps the class that it had, which it has again when that is undone.
        named = {o.id for o in self.queryable.panoptic.objects if not o.is_named_by_hand}
        for entry in content["instances"]:
            if entry["id"] in named:
                entry["class"] = given.get(entry["id"])
        return content


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(dumps(content, indent=1) + "\n", encoding="utf-8")
