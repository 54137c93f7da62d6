"""The map by what became of its instances: colours, names of the faulty ones, counts."""

from __future__ import annotations

import numpy as np

from app.evaluation.outcome_picture import DUPLICATE, INVENTED, MATCHED, REST, outcome_scene
from razer.boxes.oriented_box import OrientedBox
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap
from tests.support.surfaces import joined, plate

OUTCOMES = {
    "matches": [{"truth": 5, "predicted": 1, "iou": 1.0}, {"truth": 6, "predicted": 2, "iou": 0.5}],
    "duplicates": [3],
    "invented": [4],
    "missed": [70, 71],
}


def test_each_outcome_has_its_colour_and_the_faulty_their_names():
    none = np.zeros((0, 2), np.float32)
    unit = OrientedBox(np.zeros(3), np.eye(3), np.ones(3))
    objects = [MapObject(i, "chair", 1.0, unit, 4, 4, 5, 0, 9, none, np.zeros(0)) for i in range(1, 6)]
    mesh = joined(*(plate((3 * i, 0, 0), (1, 0, 0), (0, 1, 0), i) for i in range(6)))
    scene = outcome_scene(PanopticMap(tuple(objects), mesh), OUTCOMES)
    colors = [scene.colors.values[mesh.instances == i][0].round().tolist() for i in range(6)]
    assert [colors[i] for i in (1, 3, 4, 5, 0)] == [list(c) for c in (MATCHED, DUPLICATE, INVENTED, REST, REST)]
    assert np.ptp(colors[2]) < 0.7 * np.ptp(colors[1])  # matched by little
    assert scene.names == {4: "invented: chair", 3: "twice: chair"}
    assert [text.split()[0] for text, _ in scene.legend] == ["2", "1", "1", "2"]
