"""Lists of whole numbers as options take them: 1,2,3."""

from __future__ import annotations

from razer.errors import BadInput


def whole_numbers(option: str, text: str, least: int) -> list[int]:
    """The numbers, each `least` or more, of the text that is an option's value, none twice; raises BadInput for
    anything else, and for none."""
    try:
        numbers = list(dict.fromkeys(int(number) for number in text.split(",")))
    except ValueError:
        numbers = []
    if not numbers or min(numbers) < least:
        raise BadInput(f"{option} {text}: give whole numbers from {least} on with commas between, such as 1,2,3")
    return numbers
