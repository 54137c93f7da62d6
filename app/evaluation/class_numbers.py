"""Class numbers in files of predictions: the list of classes that says what they mean."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from data_tools.truth.ground_truth import GroundTruth
from razer.errors import BadInput
from razer.metrics.class_table import FROM_TRUTH
from razer.metrics.preset import Preset
from razer.vocabulary import vocabulary

# Lists that are a part of another one and share its numbers: what is in the larger alone is known, and not evaluated.
_PART_OF = {"scannet20": "nyu40"}
_SHOWN = 8


@dataclass(frozen=True, slots=True)
class ClassNumbers:
    """names: class names by number, above 0; source: whose numbers they are, for messages."""

    names: Mapping[int, str]
    source: str

    def named(self, numbers: Iterable[int], path: Path) -> dict[int, str]:
        """The names of the class numbers in a file, 0 left out as it stands for no class; raises BadInput naming those
        that the list lacks."""
        used = sorted({int(number) for number in numbers} - {0})
        unknown = [str(number) for number in used if number not in self.names]
        if unknown:
            more = f" and {len(unknown) - _SHOWN} more" if len(unknown) > _SHOWN else ""
            raise BadInput(
                f"{path} has the class numbers {', '.join(unknown[:_SHOWN])}{more}, which are not among those of "
                f"{self.source}: choose the --preset whose classes the file is numbered by"
            )
        return {number: self.names[number] for number in used}


def class_numbers(preset: Preset, truth: GroundTruth) -> ClassNumbers:
    """What class numbers mean in predictions that a preset evaluates: those of its whole vocabulary, whichever classes
    the truth has. Where the vocabulary is the truth's own, those of the list by which its dataset numbers classes, and
    the names in the truth itself. Raises BadInput for a vocabulary that there is not."""
    if preset.vocabulary != FROM_TRUTH:
        return _of_list(preset.vocabulary)
    listed = _of_list(truth.vocabulary) if truth.vocabulary else ClassNumbers({}, "the truth's own classes")
    own = {number: name for number, name in truth.class_names.items() if number > 0}
    return ClassNumbers({**listed.names, **own}, listed.source)


def _of_list(name: str) -> ClassNumbers:
    listed = vocabulary(_PART_OF.get(name, name))
    return ClassNumbers({each.id: each.name for each in listed.categories if each.id > 0}, listed.name)
