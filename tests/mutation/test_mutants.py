"""The mutation runner itself: what it draws, what gets imported, and what is listed of survivors."""

from __future__ import annotations

import ast
import importlib
import sys
import tomllib
from pathlib import Path

import pytest

pytest.importorskip("cosmic_ray", reason="mutants are made by cosmic-ray, of the dev extra")

from tests.mutation.mutants import Mutant, draw
from tests.mutation.survivors import listed_reasons, outdated
from tests.mutation.warm_process import MutantFinder

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
SOURCE = """from __future__ import annotations

LIMIT = 3


def shrunk(values: list[int] | None, *, by: int | float = 2) -> list[float] | None:
    # of values in the limit
    small = [value for value in values or [] if value < LIMIT]
    return [value / by for value in small] if small else None
"""


def drawn(tmp_path: Path, source: str, n: int, seed: int = 0) -> list[Mutant]:
    (tmp_path / "shrinking.py").write_text(source, encoding="utf-8")
    return draw(tmp_path, ["shrinking.py"], n, seed)


def test_mutants_compile_and_differ_by_one_line_that_is_run(tmp_path: Path) -> None:
    mutants = drawn(tmp_path, SOURCE, 1000)
    changes = {(mutant.was, mutant.becomes) for mutant in mutants}
    assert len(changes) == len(mutants) > 20
    for mutant in mutants:
        ast.parse(mutant.source)
        lines = zip(SOURCE.splitlines(), mutant.source.splitlines(), strict=True)
        assert [number for number, (was, becomes) in enumerate(lines, 1) if was != becomes] == [mutant.line]
    assert ("LIMIT = 3", "LIMIT = 4") in changes
    # Annotations are not evaluated: only the default of the signature may change.
    assert {becomes.split("->")[0].count("|") for was, becomes in changes if was.startswith("def")} == {2}


def test_a_draw_is_the_same_each_time_another_by_another_seed_and_keeps_to_lines_that_stay(tmp_path: Path) -> None:
    def keys(source: str, seed: int = 0) -> set[tuple[str, str, str]]:
        return {mutant.key for mutant in drawn(tmp_path, source, 12, seed)}

    assert len(keys(SOURCE)) == 12
    assert keys(SOURCE) == keys(SOURCE)
    assert keys(SOURCE) != keys(SOURCE, seed=1)
    assert keys(SOURCE.replace("LIMIT = 3\n", "LIMIT = 3\nNOTE = ()\n")) == keys(SOURCE)


def test_the_mutant_is_what_gets_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    changed = next(mutant for mutant in drawn(tmp_path, SOURCE, 1000) if mutant.becomes == "LIMIT = 4")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "meta_path", [MutantFinder(changed), *sys.meta_path])
    module = importlib.import_module("shrinking")
    monkeypatch.delitem(sys.modules, "shrinking")
    assert module.shrunk([2, 3, 5]) == [1.0, 1.5]


def test_every_area_has_its_modules_and_tests() -> None:
    areas = tomllib.loads((HERE / "areas.toml").read_text(encoding="utf-8"))
    assert len(areas) >= 10
    for area in areas.values():
        assert all((ROOT / path).is_file() for path in (*area["modules"], *area["tests"]))


def test_listed_survivors_have_a_reason_and_are_lines_of_today() -> None:
    reasons = listed_reasons()
    assert reasons
    assert outdated(reasons, ROOT) == []
    assert all(was != becomes for _, was, becomes in reasons)
    assert all(len(reason.split()) > 3 for reason in reasons.values())


def test_a_listed_survivor_is_out_of_date_once_its_line_is_gone(tmp_path: Path) -> None:
    (tmp_path / "here.py").write_text("if True:\n    x = f(1,\n          2)\n")
    reasons = {("here.py", was, "y"): "" for was in ("x = f(1, 2)", "x = f(1)")} | {("gone.py", "x", "y"): ""}
    assert outdated(reasons, tmp_path) == [("here.py", "x = f(1)", "y"), ("gone.py", "x", "y")]
