"""Rules of an evaluation: a preset, with some of them changed on the command line."""

from __future__ import annotations

from pydantic import ValidationError

from app.settings.assignments import parse_value, split_assignment
from razer.errors import BadInput
from razer.metrics.preset import Preset
from razer.metrics.presets import PRESETS
from razer.settings import problem_of


def choose_rules(preset: str, assignments: tuple[str, ...]) -> Preset:
    """The preset of this name with the rules that texts "rule=value" change; raises BadInput naming what is wrong."""
    if preset not in PRESETS:
        raise BadInput(f"no preset '{preset}': choose one of {', '.join(PRESETS)}")
    rules = PRESETS[preset].model_dump()
    form = f"rule=value, with one of the rules {', '.join(rules)}"
    for assignment in assignments:
        name, value = split_assignment(assignment, form, rules)
        rules[name] = None if value in ("none", "null") else parse_value(value)
    try:
        return Preset.model_validate(rules)
    except ValidationError as error:
        first = error.errors()[0]
        raise BadInput(f"--set {first['loc'][0]}: {problem_of(error)}") from None
