"""Named sets of settings, which a config file and --set override: `paper` takes back every departure from the paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from razer.errors import BadInput

# Each departure of docs/method.md that a setting can take back, in the order of the steps, and how.
DEPARTURES: Mapping[str, Mapping[str, Any]] = {
    "masks: borders kept": {"masks.shrink_pixels": 0},
    "lifting: each cluster a detection": {"lifting.detections": "cluster", "lifting.min_cells": 4},
    "lifting: background kept": {"lifting.drop_background": False},
    "lifting: moments of readings": {"lifting.points": "readings"},
    "lifting: box about the centroid": {"lifting.box_center": "centroid"},
    "association: V by box IoU": {"association.geometry_distance": "paper"},
    "association: S Euclidean": {"association.semantic_distance": "euclidean"},
    "association: no gate": {"association.gate": 3.0},
    "association: no joining": {"association.join": False},
    "tracks: moments added up": {"maintenance.moments": "sums"},
    "tracks: at once": {"maintenance.tentative": False, "maintenance.min_confidence": 0.0},
    "bank: raw cosine": {"bank.similarity_scale": "cosine"},
    "bank: no outliers": {"bank.outlier": -1.0},
    "bank: newcomers dropped when full": {"bank.when_full": "drop"},
    "bank: hypotheses not merged": {"bank.merge_hypotheses": False},
    "votes: within boxes": {"maintenance.label_votes": "box"},
    "votes: never withdrawn": {"maintenance.withdraw_votes": False},
    "votes: others not spared": {"maintenance.spare_others": False},
    "map: pruning by support": {"maintenance.pruning": "support"},
    "map: no consensus": {"maintenance.fuse_duplicates": False},
    "map: no carving": {"voxels.carve_every": 0},
    "mesh: label of the nearest voxel": {"voxels.vertex_labels": "voxel"},
    "mesh: seams left": {"voxels.seam_rings": 0},
    "mesh: surface not segmented": {"surface_segmentation.use": "never"},
}
PAPER: Mapping[str, Any] = {name: value for changes in DEPARTURES.values() for name, value in changes.items()}
PRESETS: Mapping[str, Mapping[str, Any]] = {"paper": PAPER}


def preset_settings(name: str | None) -> Mapping[str, Any]:
    """The settings of a preset by dotted name, none for None; raises BadInput for a preset that there is not."""
    if name is None:
        return {}
    if name not in PRESETS:
        raise BadInput(f"--preset {name}: there is no such preset; choose from {', '.join(PRESETS)}")
    return PRESETS[name]
