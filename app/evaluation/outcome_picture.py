"""Picture of a map by what became of its instances in an evaluation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.pictures.label_drawing import Color
from app.pictures.map_picture import Scene
from app.pictures.scenes import ceilings
from app.pictures.style_colors import VertexColors
from razer.panoptic_map import PanopticMap

# Blue, yellow and red stay apart for any colour vision; what matched by little is paler.
MATCHED, BARELY = (58, 120, 178), (160, 196, 224)
DUPLICATE, INVENTED, MISSED, REST = (226, 178, 60), (190, 70, 60), (90, 94, 100), (196, 198, 202)
_LEAST_IOU = 0.5


def outcome_scene(panoptic: PanopticMap, outcomes: Mapping[str, Any]) -> Scene:
    """The map with matched instances in blue, the paler the less they overlap, duplicates in yellow, inventions in red,
    what does not count in grey; the faulty ones have their names.

    Args:
        panoptic: the map that was evaluated.
        outcomes: of its scene, as in `Evaluation.scenes`.
    """
    matched = {match["predicted"]: _matched(match["iou"]) for match in outcomes["matches"]}
    duplicates, invented, missed = (list(outcomes.get(key, ())) for key in ("duplicates", "invented", "missed"))
    colors = matched | dict.fromkeys(duplicates, DUPLICATE) | dict.fromkeys(invented, INVENTED)
    names = {o.id: o.class_name or "thing" for o in panoptic.objects}
    faulty = {number: f"{what}: {names[number]}" for what, group in (("invented", invented), ("twice", duplicates))
              for number in group if number in names}  # fmt: skip
    legend = [
        (f"{len(matched)} matched", MATCHED),
        (f"{len(duplicates)} found twice", DUPLICATE),
        (f"{len(invented)} invented", INVENTED),
        (f"{len(missed)} missed, so not here", MISSED),
    ]
    painted = VertexColors.of_ids(panoptic.mesh, colors, REST)
    up, wanted = panoptic.up_or_z, [*faulty, *matched]
    return Scene(panoptic.mesh, painted, up, faulty, wanted, ceilings(panoptic), legend)


def _matched(iou: float) -> Color:
    """From pale at the least overlap of a match to full blue."""
    share = min(max((iou - _LEAST_IOU) / (1 - _LEAST_IOU), 0.0), 1.0)
    red, green, blue = (round(a + share * (b - a)) for a, b in zip(BARELY, MATCHED, strict=True))
    return red, green, blue
