"""Finished runs of recordings with a truth: which instance stands for which true thing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.evaluation.evaluate_run import truth_for, truth_scene
from app.evaluation.prediction import read_prediction
from app.query.queryable_map import open_map
from razer.errors import BadInput
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.scene_result import evaluate_scene
from razer.models.oracle.embedder import OracleEmbedder
from razer.panoptic_map import PanopticMap
from razer.semantics.labelling import known_names


@dataclass(frozen=True)
class MatchedRun:
    """A map, the names of its truth's classes that the embedder knows, and, by id, the class of the true thing that an
    instance stands for at IoU 0.5."""

    panoptic: PanopticMap
    names: Sequence[str]
    true_names: Mapping[int, str]

    @classmethod
    def open(cls, run: Path) -> MatchedRun:
        """Open a finished run whose recording has a truth; raises BadInput."""
        panoptic, config = open_map(run)
        if config.input.folder is None:
            raise BadInput(f"{run} does not say which recording it was made of: run again")
        truth = truth_for(Path(config.input.folder), PRESETS["default"])
        names = known_names(panoptic, sorted(set(truth.class_names.values())), "of the truth")
        predicted = read_prediction(run, truth.class_names, len(truth.vertices), naming="run")
        result = evaluate_scene(run.name, truth_scene(truth), predicted, PRESETS["default"]).instances
        assert result is not None
        known = {int(i) for i in panoptic.embedding_table.ids}
        found = {
            match.predicted: name
            for match in result.match_summary.matches
            if match.predicted in known and (name := truth.instance_classes.get(match.truth, "")) in names
        }
        return cls(panoptic, names, found)

    def with_exemplars(self) -> MatchedRun | None:
        """The same map with embeddings free of noise: that of the class's exemplar for each matched instance. None
        where the run's embedder was not the oracle with exemplars."""
        queries = self.panoptic.text_queries
        embedder = None if queries is None else queries.embedder
        if not isinstance(embedder, OracleEmbedder) or embedder.profile is None:
            return None
        exemplar = {name: embedder.profile.exemplar(name) for name in {*self.true_names.values()}}
        unit = {name: (v / np.linalg.norm(v)).astype(np.float32)[None] for name, v in exemplar.items()}
        objects = tuple(
            replace(o, embeddings=unit[self.true_names[o.id]], weights=np.ones(1)) if o.id in self.true_names else o
            for o in self.panoptic.objects
        )
        return replace(self, panoptic=replace(self.panoptic, objects=objects))
