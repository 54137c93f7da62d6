"""Normal forms of short English phrases: without openings, articles, plurals and inflected verbs."""

from __future__ import annotations

import re
from collections.abc import Iterator

_DETERMINER = re.compile("an?|the|some|any|all|every|each|my|your|our|his|her|their|its|this|these|those")
# What a question or a wish opens with before it says what it is about.
_OPENING = re.compile(
    "something|anything|everything|somewhere|anywhere|stuff|furniture|equipment|of|what|where|which|that|is|are|be|there|"
    "(?:place|spot|thing|object|item|piece|kind|sort|type|pair|device|tool|machine)s?|find|show|me|please|i|we|you|one|"
    "people|someone|want|need|like|would|can|could|may|do|does|used?|made|meant|good|suitable|to|for"
)
# Openings after which a verb follows: "something to sit on", "where I can sit", "for sitting on".
_BEFORE_VERB = re.compile("to|for|can|could|may")
_PARTICLE = re.compile("on|upon|onto|in|into|from|with|at|off|of|out|up|down")
_IRREGULAR = {"people": "person", "children": "child", "men": "man", "women": "woman", "mice": "mouse"}
_IRREGULAR |= {"feet": "foot", "teeth": "tooth", "geese": "goose", "oxen": "ox"}
_ENDINGS = (("ves", "f"), ("ves", "fe"), ("ies", "y"), ("es", ""), ("s", ""))
_AND = re.compile(r"\s*(?:[,;/]|\band\b|\bor\b)[\s,;/]*(?:(?:and|or)\b\s*)?", re.IGNORECASE)


def plain(text: str) -> str:
    """A text as phrases are compared: lower case, words with single spaces between, no determiners."""
    words = re.sub(r"[^\w&']+|_", " ", text.lower()).split()
    return " ".join(word for word in words if not _DETERMINER.fullmatch(word))


def alternatives(text: str) -> list[str]:
    """The parts of an enumeration: "dishes, cups and cutlery" has three."""
    return [part for part in _AND.split(text.strip()) if part]


def without_openings(phrase: str) -> Iterator[tuple[str, bool]]:
    """A plain phrase, then what is left of it as one opening word after the other goes; and whether one of those gone
    says that a verb follows."""
    words = phrase.split()
    for start in range(len(words)):
        if start and not _OPENING.fullmatch(words[start - 1]):
            return
        yield " ".join(words[start:]), any(map(_BEFORE_VERB.fullmatch, words[:start]))


def singulars(phrase: str) -> list[str]:
    """A plain phrase, and what its last word may be the plural of."""
    *head, last = phrase.split() or [""]
    forms = [last, *([_IRREGULAR[last]] if last in _IRREGULAR else [])]
    forms += [last[: -len(plural)] + one for plural, one in _ENDINGS if last.endswith(plural) and len(last) > 3]
    return [" ".join([*head, form]) for form in forms]


def verb_forms(phrase: str) -> list[str]:
    """A plain phrase that begins with a verb, and the same with its gerund and its third person, as far as spelling
    tells."""
    verb, *rest = phrase.split()
    stem = verb[:-1] if verb.endswith("e") and not verb.endswith("ee") else verb
    stem = verb[:-2] + "y" if verb.endswith("ie") else stem
    doubled = [f"{verb}{verb[-1]}ing"] if re.fullmatch(r".*[^aeiou][aeiou][bdgmnprt]", verb) else []
    return [" ".join([form, *rest]) for form in (verb, f"{verb}s", f"{verb}es", f"{stem}ing", *doubled)]


def without_particles(phrase: str) -> Iterator[str]:
    """A plain phrase, then what is left as one particle after the other goes from its end: "lie down on"."""
    words = phrase.split()
    yield phrase
    while len(words) > 1 and _PARTICLE.fullmatch(words[-1]):
        words.pop()
        yield " ".join(words)
