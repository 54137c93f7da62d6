"""Mutants of a module by cosmic-ray's default operators (Bingham and Smith), drawn so that a change in one line leaves
most of the draw as it was."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names


@dataclass(frozen=True)
class Mutant:
    """A source file with one place changed: the line as it `was` and as it `becomes`, and the whole new `source`."""

    path: str
    line: int
    was: str
    becomes: str
    source: str

    @property
    def key(self) -> tuple[str, str, str]:
        """What a survivor is listed by: it holds as long as the line reads the same, wherever it moves."""
        return self.path, self.was, self.becomes


@dataclass(frozen=True)
class _Place:
    """One application of one operator, known by the text that it is applied to."""

    path: str
    operator: str
    occurrence: int
    line: str
    column: int

    def rank(self, seed: int) -> bytes:
        """Where in the draw: a hash, so that what stands elsewhere in the file does not matter."""
        place = (seed, self.path, self.operator, self.line.strip(), self.column)
        return hashlib.sha256(repr(place).encode()).digest()


def draw(root: Path, paths: Iterable[str], n: int, seed: int) -> list[Mutant]:
    """`n` mutants of some files, or all where they have no more, in the order of their lines. None of them but compiles
    and differs in what is run: annotations are never evaluated, so that no test could see them changed."""
    originals = {path: (root / path).read_text(encoding="utf-8") for path in paths}
    places = [place for path, original in originals.items() for place in _places(path, original)]
    drawn: dict[tuple[str, str, str], Mutant] = {}
    for place in sorted(places, key=lambda place: place.rank(seed)):
        if len(drawn) == n:
            break
        mutant = _applied(place, originals[place.path])
        if mutant is not None:
            drawn.setdefault(mutant.key, mutant)
    return sorted(drawn.values(), key=lambda mutant: (mutant.path, mutant.line, mutant.becomes))


def _places(path: str, original: str) -> Iterator[_Place]:
    lines, tree = original.splitlines(), get_ast(original)
    for name in operator_names():
        if get_operator(name).arguments():  # such operators need names to be given, and run on none by default
            continue
        operator = get_operator(name)()
        starts = [start for node in ast_nodes(tree) for start, _ in operator.mutation_positions(node)]
        for occurrence, (row, column) in enumerate(starts):
            indent = len(lines[row - 1]) - len(lines[row - 1].lstrip())
            yield _Place(path, name, occurrence, lines[row - 1], column - indent)


def _applied(place: _Place, original: str) -> Mutant | None:
    source = mutate_code(original, get_operator(place.operator)(), place.occurrence)
    if source is None or _meaning(source) in (None, _meaning(original)):
        return None
    return _located(place.path, original, source)


def _meaning(source: str) -> str | None:
    """The syntax tree without annotations, None for what is not Python."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return None
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            node.returns = None
        elif isinstance(node, ast.arg):
            node.annotation = None
        elif isinstance(node, ast.AnnAssign):
            node.annotation = ast.Constant(value=None)
    return ast.dump(tree)


def _located(path: str, original: str, source: str) -> Mutant:
    before, after = original.splitlines(), source.splitlines()
    blocks = SequenceMatcher(None, before, after, autojunk=False).get_opcodes()
    tag, first, last, to_first, to_last = next(block for block in blocks if block[0] != "equal")
    was, becomes = (" ".join(line.strip() for line in part) for part in (before[first:last], after[to_first:to_last]))
    return Mutant(path, first + 1, was, becomes if tag != "delete" else "", source)
