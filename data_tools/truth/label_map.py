"""Label map of ScanNet, scannetv2-labels.combined.tsv: from an annotator's name for an object to its class.

The column id holds the numbers of ScanNet200, nyu40id those of NYU40 and ScanNet20. Source: ScanNet's benchmark
scripts, https://github.com/ScanNet/ScanNet/tree/master/BenchmarkScripts
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from data_tools.truth.class_names import category_of
from razer.errors import BadInput
from razer.files import MALFORMED, read_lines
from razer.vocabulary import Category, Vocabulary

FILE_NAME = "scannetv2-labels.combined.tsv"
_NUMBER_COLUMN = {"scannet200": "id", "nyu40": "nyu40id", "scannet20": "nyu40id"}


@dataclass(frozen=True, slots=True)
class LabelMap:
    """The rows of the file by raw_category."""

    path: Path
    rows: Mapping[str, Mapping[str, str]]

    def category(self, name: str, classes: Vocabulary) -> Category | None:
        """The class of a raw name, by the number its row has; in another list than ScanNet's by the names in its row.
        None where the list lacks it; raises KeyError for a name that is not in the file."""
        row = self.rows[name]
        column = _NUMBER_COLUMN.get(classes.name)
        if column is not None:
            return classes.by_id.get(int(row[column] or 0))
        return category_of(name, classes) or category_of(row["category"], classes)


def find_label_map(folder: Path) -> LabelMap | None:
    """The file in a folder or the nearest one above it; raises BadInput where it cannot be understood."""
    places = (place / FILE_NAME for place in (folder, *folder.parents))
    path = next((place for place in places if place.is_file()), None)
    return None if path is None else read_label_map(path)


def read_label_map(path: Path) -> LabelMap:
    """The file of ScanNet's release; raises BadInput naming it. The first row of a name counts."""
    try:
        rows = list(csv.DictReader(read_lines(path), delimiter="\t"))
        for row in rows:
            int(row["id"] or 0), int(row["nyu40id"] or 0), row["raw_category"].strip(), row["category"].strip()
    except (*MALFORMED, csv.Error) as error:
        raise BadInput(
            f"{path} must have the tab-separated columns id, raw_category, category, nyu40id (problem: {error!r})"
        ) from None
    return LabelMap(path, {row["raw_category"]: row for row in reversed(rows)})
