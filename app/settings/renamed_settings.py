"""Former settings: refused with the new name, or with what took their place, where a user writes them; translated or
left out in older run folders."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

RENAMED = {
    "follow.enabled": "reintegration.enabled",
    "follow.every": "reintegration.frames_per_keyframe",
    "follow.draft": "reintegration.keyframe_stride",
    "follow.live_replays": "reintegration.replays_per_frame",
    "follow.pace": "reintegration.max_replays_per_frame",
    "follow.live_shift_voxels": "reintegration.min_shift_voxels",
    "follow.final_shift_voxels": "reintegration.min_final_shift_voxels",
    "follow.fuse_shared_votes": "reintegration.fuse_shared_votes",
    "follow.memory_mb": "reintegration.memory_mb",
    "maintenance.every": "maintenance.interval_frames",
    "association.association": "association.geometry_distance",
    "lifting.see_through_gap_m": "lifting.background_gap_m",
    "timeline.points_every": "timeline.surface_every",
    "timeline.points_growth": "timeline.surface_growth",
}

REMOVED = {
    "maintenance.confirm_hits": "a track is an instance while it is more likely a thing than not, by all views",
    "maintenance.fuse_consensus": "see maintenance.fuse_log_odds",
    "maintenance.fuse_frames": "see maintenance.fuse_log_odds",
    "maintenance.fuse_prior": "see maintenance.fuse_log_odds",
    "maintenance.fuse_cosine": "see maintenance.fuse_log_odds",
    "slam.loop_closure.min_similarity": "see slam.loop_closure.min_similarity_sigmas",
    "slam.loop_closure.min_submap_similarity": "submaps are compared with the places most alike, however alike",
    "timeline.boxes_every": "boxes come with the surface: see timeline.surface_every",
    "timeline.points_thinning": "the map grows as a surface: see timeline.surface_cell_m",
}


def with_new_names(tree: dict[str, Any]) -> dict[str, Any]:
    """Settings as a TOML file holds them, under the names of today, without those that there are no more; a setting
    under both names keeps the new one's."""
    translated = deepcopy(tree)
    for old, new in RENAMED.items():
        (old_section, old_key), (new_section, new_key) = old.split("."), new.split(".")
        keys = translated.get(old_section)
        if not isinstance(keys, dict) or old_key not in keys:
            continue
        value = keys.pop(old_key)
        if not keys:
            del translated[old_section]  # no section of today may bear its name
        target = translated.setdefault(new_section, {})
        if isinstance(target, dict):
            target.setdefault(new_key, value)
    for name in REMOVED:
        *sections, key = name.split(".")
        keys = translated
        for section in sections:
            keys = keys.get(section) if isinstance(keys, dict) else None
        if isinstance(keys, dict):
            keys.pop(key, None)
    return translated
