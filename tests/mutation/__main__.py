"""Mutation testing of the method's core: `python -m tests.mutation` draws mutants by a fixed seed, runs the tests that
concern each, and fails where fewer are killed than must be or where one survives without a reason in survivors.toml."""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tests.mutation.mutants import Mutant, draw
from tests.mutation.survivors import listed_reasons, outdated
from tests.mutation.warm_process import TIMED_OUT, Job, run_all, warm_up

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
MUST_KILL = 0.85
# A mutant may loop for ever; one that is merely slower than this is as good as noticed.
LIMIT_S, LIMIT_SHARE = 10.0, 4.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code 0 where enough mutants are killed and each survivor has its reason."""
    options = _options(arguments)
    os.chdir(ROOT)
    areas = tomllib.loads((HERE / "areas.toml").read_text(encoding="utf-8"))
    areas = {name: area for name, area in areas.items() if options.area in (None, name)}
    drawn = {name: draw(ROOT, area["modules"], options.per_area, options.seed) for name, area in areas.items()}
    warm_up()
    limits_s = _limits_s(areas, options.jobs)
    tests = {path: area["tests"] for area in areas.values() for path in area["modules"]}
    jobs = [Job(m, tests[m.path], limits_s[tuple(tests[m.path])]) for mutants in drawn.values() for m in mutants]
    codes = {job.mutant: code for job, code, _ in run_all(jobs, options.jobs)}
    return _report(drawn, codes)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser("python -m tests.mutation", description=__doc__)
    parser.add_argument("--per-area", type=int, default=32, help="how many mutants of each area")
    parser.add_argument("--seed", type=int, default=0, help="another draw")
    parser.add_argument("--area", help="this area of areas.toml alone")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), help="how many at once")
    return parser.parse_args(arguments)


def _limits_s(areas: dict[str, dict[str, list[str]]], n_at_once: int) -> dict[tuple[str, ...], float]:
    """Time limits of the areas' tests, from how long they take on the code as it is, which has to pass them."""
    jobs = [Job(None, area["tests"], 600.0) for area in areas.values()]
    limits_s = {}
    for job, code, seconds in run_all(jobs, n_at_once):
        if code:
            sys.exit(f"Without a mutant these fail already (exit code {code}): {' '.join(job.tests)}")
        limits_s[tuple(job.tests)] = max(LIMIT_S, LIMIT_SHARE * seconds)
    return limits_s


def _report(drawn: dict[str, list[Mutant]], codes: dict[Mutant | None, int]) -> int:
    reasons, everything = listed_reasons(), [m for mutants in drawn.values() for m in mutants]
    table = Table("area", "mutants", "killed", "killed by time", "survived", "with a reason")
    for area, mutants in (*drawn.items(), ("all", everything)):
        survivors = [m for m in mutants if codes[m] == 0]
        n_late, n_listed = sum(codes[m] == TIMED_OUT for m in mutants), sum(m.key in reasons for m in survivors)
        counts = (len(mutants), len(mutants) - len(survivors), n_late, len(survivors), n_listed)
        table.add_row(area, *map(str, counts))
    Console(width=120).print(table)
    unexplained = [m for m in everything if codes[m] == 0 and m.key not in reasons]
    for m in unexplained:
        print(f"survived: {m.path}:{m.line}\n  was     {m.was}\n  becomes {m.becomes}")
    gone = outdated(reasons, ROOT)
    for path, was, _ in gone:
        print(f"listed in survivors.toml, but not in {path}: {was}")
    share = sum(codes[m] != 0 for m in everything) / max(1, len(everything))
    print(f"killed: {share:.1%} of {len(everything)}, must be {MUST_KILL:.0%}; without a reason: {len(unexplained)}")
    return int(share < MUST_KILL or bool(unexplained or gone))


if __name__ == "__main__":
    sys.exit(main())
