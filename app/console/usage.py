"""Wrong usage in the words of the help."""

from __future__ import annotations

import re

_KINDS = {"int": "a whole number", "float": "a number", "bool": "true or false", "Path": "a path", "str": "a text"}


def usage_text(message: str) -> str:
    """What the parser of the command line says, without its own terms: commands, parameters, tokens, types."""
    message = re.sub(r'^(Command "[^"]*" parameter|Parameter) ', "", message)
    message = re.sub(r"^(-\S+) requires an argument\.", r"\1 needs a value.", message)
    message = re.sub(r"^(\S+) requires an argument\.", r"\1 is missing.", message)
    message = re.sub(
        r"^(\S+) requires (\d+) positional arguments\. Only got (\d+)\.", r"\1 needs \2 values, not \3.", message
    )
    message = re.sub(r"^(\S+) accepts at most (\d+) elements?\. Got (\d+)\.", r"\1 takes \2 at most, not \3.", message)
    message = message.replace(" specified multiple times.", " is given more than once.")
    message = re.sub(r'unable to convert "(.*)" into (\w+)\.', _converted, message)
    return re.sub(r"^Unused Tokens: \[(.*)\]\.", r"too many arguments: \1.", message)


def _converted(match: re.Match[str]) -> str:
    return f'"{match[1]}" should be {_KINDS.get(match[2], match[2])}.'
