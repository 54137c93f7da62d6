"""A map at one epoch, with everything that is asked of it; worked out once, when it is first asked for."""

from __future__ import annotations

import secrets
import tempfile
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from app.page.instance_records import instance_records, relation_records
from app.render.glb import NodeFacts, write_glb
from app.served_map.answer_models import MapRelation, QueryAnswer, QueryHit
from app.served_map.crop_pictures import CropPictures
from app.served_map.instance_models import (
    ClassGuess,
    Instance,
    InstanceDetail,
    InstanceFilter,
    InstanceList,
    InstanceRelation,
)
from app.served_map.named_graph import named_graph
from razer.arrays import Uint8Array
from razer.errors import BadInput
from razer.map_object import Answer, Hit
from razer.models import ImageEncoder
from razer.panoptic_map import PanopticMap
from razer.query.ranking import PRESENT

T = TypeVar("T")


class NoSuchInstance(BadInput):
    """An instance, or a picture of one, that the map does not have."""


class AskedMap:
    """A map that does not change any more; safe to ask from several threads."""

    def __init__(self, epoch: int, panoptic: PanopticMap, crops: CropPictures) -> None:
        self.epoch, self.panoptic, self._crops = epoch, panoptic, crops
        self.tag = f"{secrets.token_hex(4)}-{epoch}"  # of no other map, to know answers by
        self._locks_lock, self._locks = threading.Lock(), dict[str, threading.Lock]()
        self._known: dict[str, Any] = {}

    def once(self, name: str, make: Callable[[], T]) -> T:
        """What `make` gives, made by the first thread that asks; others wait for it, and not for what has other
        names."""
        if name not in self._known:
            with self._locks_lock:
                lock = self._locks.setdefault(name, threading.Lock())
            with lock:
                if name not in self._known:
                    self._known[name] = make()
        return self._known[name]

    @property
    def instances(self) -> Mapping[int, Instance]:
        """All instances and parts by id."""
        return self.once("instances", self._instances)

    def _instances(self) -> dict[int, Instance]:
        items = {item.id: item for item in (*self.panoptic.objects, *self.panoptic.parts)}
        records = (r | {"crops": self._crops.count(items[r["id"]])} for r in instance_records(self.panoptic))
        return {record["id"]: Instance.model_validate(record) for record in records}

    @property
    def relations(self) -> list[MapRelation]:
        """All relations."""
        return self.once("relations", self._relations)

    def _relations(self) -> list[MapRelation]:
        return [MapRelation.model_validate(record) for record in relation_records(self.panoptic)]

    @property
    def graph(self) -> dict[str, Any]:
        """{nodes, edges}."""
        return self.once("graph", lambda: named_graph(self.panoptic, list(self.instances.values())))

    @property
    def glb(self) -> bytes:
        """The mesh as binary glTF, a named node for each instance."""
        return self.once("glb", self._glb)

    def _glb(self) -> bytes:
        named = {i: entry.name if _has_name(entry) else None for i, entry in self.instances.items()}
        facts = {i: NodeFacts(name, self.instances[i].score) for i, name in named.items()}
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "mesh.glb"
            write_glb(path, self.panoptic.mesh, self.panoptic.up_or_z, facts)
            return path.read_bytes()

    def listed(self, wanted: InstanceFilter) -> InstanceList:
        """The page of instances that is wanted."""
        passing = [entry for entry in self.instances.values() if wanted.passes(entry)]
        shown = passing[wanted.offset : wanted.offset + wanted.limit]
        return InstanceList(epoch=self.epoch, total=len(passing), instances=shown)

    def detail(self, instance_id: int) -> InstanceDetail:
        """One instance with its relations; raises NoSuchInstance."""
        entry = self._entry(instance_id)
        relations = [
            InstanceRelation(relation=r.relation, other=r.object, other_name=self._name(r.object))
            for r in self.relations
            if r.subject == instance_id
        ]
        return InstanceDetail(**entry.model_dump(), epoch=self.epoch, relations=relations)

    def crop(self, instance_id: int, number: int) -> bytes:
        """A picture of an instance as JPEG, the best one has number 0; raises NoSuchInstance."""
        self._entry(instance_id)
        item = next(o for o in (*self.panoptic.objects, *self.panoptic.parts) if o.id == instance_id)
        picture = self._crops.picture(item, number)
        if picture is None:
            n = self._entry(instance_id).crops
            raise NoSuchInstance(f"instance {instance_id} has no picture {number}: there are {n} of it")
        return picture

    def ask(self, text: str, limit: int, least: float = PRESENT) -> QueryAnswer:
        """What a text means with a least probability; raises BadInput where the embedder cannot tell."""
        return self._answer(text, self.panoptic.query(text, least), limit)

    def ask_picture(self, rgb: Uint8Array, limit: int, least: float = PRESENT) -> QueryAnswer:
        """What looks like a picture (H, W, 3) with a least probability; raises BadInput where no embedder takes one."""
        embedder = None if self.panoptic.text_queries is None else self.panoptic.text_queries.embedder
        if not isinstance(embedder, ImageEncoder):
            raise BadInput("this map's embedder takes no pictures: ask by words")
        vector = embedder.embed_region(rgb, np.ones(rgb.shape[:2], np.bool_))
        return self._answer("(picture)", self.panoptic.query_image(vector, least), limit)

    def _entry(self, instance_id: int) -> Instance:
        if instance_id not in self.instances:
            raise NoSuchInstance(f"there is no instance {instance_id} in this map")
        return self.instances[instance_id]

    def _name(self, instance_id: int) -> str:
        return self.instances[instance_id].name if instance_id in self.instances else "thing"

    def _answer(self, query: str, answer: Answer, limit: int) -> QueryAnswer:
        return QueryAnswer(
            epoch=self.epoch,
            query=query,
            found=answer.found,
            statement=_statement(query, len(answer.hits)),
            hits=[_hit(hit, self._name(hit.object.id)) for hit in answer.best(limit).hits],
        )


def _statement(query: str, n_hits: int) -> str:
    if n_hits == 0:
        return f"not in this map: {query}"
    return f"{n_hits} {'instance' if n_hits == 1 else 'instances'} in this map: {query}"


def _hit(hit: Hit, name: str) -> QueryHit:
    runner_up = hit.runner_up and ClassGuess(name=hit.runner_up[0], probability=round(min(hit.runner_up[1], 1.0), 4))
    return QueryHit(
        id=hit.object.id,
        name=hit.object.class_name or hit.class_guess or name,
        probability=round(min(hit.score, 1.0), 4),
        score=round(hit.object.score, 4),
        runner_up=runner_up,
        center_m=[round(float(x), 5) for x in hit.object.box.center],
        extent_m=[round(float(x), 5) for x in hit.object.box.extent],
    )


def _has_name(entry: Instance) -> bool:
    """Whether anything is known of what an instance is called."""
    return bool(entry.class_guesses) or entry.name not in ("thing", "part")
