"""A run whose instances have classes: its files and what is said of it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from json import dumps, loads
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from app.console.streams import result_console
from app.query.queryable_map import QueryableMap
from app.render.glb import instance_names, write_glb
from app.render.palette import instance_colors
from app.run_folder import run_folder as names
from razer.semantics.labelling import Label, Segment, segment_ids, segments
from razer.semantics.scene_graph import scene_graph
from razer.storage.atomic_files import replace_files
from razer.storage.ply import VERTEX, vertex_rows, write_ply
from razer.volume.mesh_extraction import LabelledMesh

FORMAT = 1
PANOPTIC_VERTEX = np.dtype([*VERTEX.descr, ("class", "<i4")])


@dataclass(frozen=True)
class LabelledRun:
    """The classes of a run's instances, and the things and stuff they make up."""

    asked: QueryableMap
    vocabulary: str
    labels: list[Label]
    segments: list[Segment]

    @classmethod
    def of(cls, asked: QueryableMap, vocabulary: str, labels: list[Label]) -> LabelledRun:
        """Merge stuff."""
        return cls(asked, vocabulary, labels, segments(labels))

    def write(self) -> None:
        """Make the files anew; they take their places once all are complete, instances.json as the last."""
        folder, mesh = self.asked.folder, self._mesh()
        graph = scene_graph(self.asked.panoptic, self.segments, self.asked.up)
        classes = {s.id: s.category.name for s in self.segments}
        table = {"format": FORMAT, "vocabulary": self.vocabulary, "segments": self._table(mesh)}
        instances = self._instances()
        replace_files(
            {
                folder / names.PANOPTIC: lambda path: _write_json(path, table),
                folder / names.SCENE_GRAPH: lambda path: _write_json(path, graph),
                folder / names.PANOPTIC_PLY: lambda path: self._write_panoptic_ply(path, mesh),
                folder / names.MESH_GLB: lambda path: write_glb(path, mesh, self.asked.up, instance_names(classes)),
                folder / names.INSTANCES: lambda path: _write_json(path, instances),
            }
        )

    def told(self) -> dict[str, Any]:
        """The JSON of `razer label`."""
        instances = [
            {
                "id": found.id,
                "class": found.category.name,
                "score": round(found.score, 4),
                "runner_up": found.runner_up.name if found.runner_up else None,
            }
            for found in self.labels
        ]
        stuff = [
            {"id": s.id, "class": s.category.name, "instances": list(s.instances)}
            for s in self.segments
            if s.category.stuff
        ]
        return {"vocabulary": self.vocabulary, "instances": instances, "stuff": stuff}

    def report(self) -> None:
        """How many of each class there are, and where the files lie."""
        table = Table()
        table.add_column("class")
        table.add_column("instances", justify="right")
        table.add_column("ids")
        counts = Counter(found.category.name for found in self.labels)
        for name, count in counts.most_common():
            ids = ", ".join(str(found.id) for found in self.labels if found.category.name == name)
            table.add_row(name, str(count), ids)
        console = result_console()
        console.print(table)
        console.print(f"outputs: {self.asked.folder}", soft_wrap=True)

    def _mesh(self) -> LabelledMesh:
        """The mesh whose instances are segments."""
        mesh = self.asked.panoptic.mesh
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
        categories = segment_ids(self.asked.panoptic.mesh, self.segments)[1]
        shown = LabelledMesh(mesh.vertices, instance_colors(categories), mesh.instances, mesh.triangles)
        vertices = vertex_rows(shown, PANOPTIC_VERTEX)
        vertices["instance"], vertices["class"] = mesh.instances, categories
        write_ply(path, vertices, mesh.triangles)

    def _instances(self) -> dict[str, Any]:
        content: dict[str, Any] = loads((self.asked.folder / names.INSTANCES).read_text(encoding="utf-8"))
        given = {found.id: found.category.name for found in self.labels}
        for entry in content["instances"]:
            entry["class"] = given.get(entry["id"])
        return content


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(dumps(content, indent=1) + "\n", encoding="utf-8")
