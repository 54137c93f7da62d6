"""Names of combinations of segmenters: "yolo+semantic", or "near=yolo+far=yolo" for two of a kind."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from razer.errors import BadInput

OWN_OPTIONS = ("iou",)  # of a combination itself, beside those of its parts
_RESERVED = (*OWN_OPTIONS, "parts")
_LABEL = re.compile(r"[A-Za-z][\w-]*")


def part_names(name: str) -> dict[str, str]:
    """The segmenter of each part by the label under which its options are found, in order.

    A part is "segmenter" or "label=segmenter"; without a label it is called as the segmenter is, one from outside
    ("module:Class") as its class. Raises BadInput."""
    parts: dict[str, str] = {}
    for text in name.split("+"):
        label, _, segmenter = (piece.strip() for piece in text.rpartition("="))
        label = label or segmenter.rpartition(":")[2]
        if not segmenter or not _LABEL.fullmatch(label) or label in _RESERVED:
            raise BadInput(f"segmenter '{name}': write parts as in yolo+semantic, or with names, near=yolo+far=yolo")
        if label in parts:
            raise BadInput(
                f"segmenter '{name}' has two parts called {label}: name them, as in a={segmenter}+b={segmenter}"
            )
        parts[label] = segmenter
    return parts


def part_options(name: str, parts: Mapping[str, str], options: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The options of each part; raises BadInput for options that belong to none."""
    for label, value in options.items():
        if label not in parts:
            first = next(iter(parts))
            raise BadInput(
                f"segmenter '{name}' has no part '{label}': options are those of its parts {', '.join(parts)}, as in "
                f"segmenter.options.{first}.weights=FILE, and {', '.join(OWN_OPTIONS)}"
            )
        if not isinstance(value, Mapping):
            raise BadInput(f"segmenter.options.{label} = {value!r}: write segmenter.options.{label}.OPTION=VALUE")
    return {label: dict(options.get(label, {})) for label in parts}
