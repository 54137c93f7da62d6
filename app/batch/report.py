"""The report of a batch: kept up to date while it goes on, so that a batch that was killed knows what is done."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from rich.console import Console
from rich.table import Table

from app.engines.task import Outcome
from app.object_store.place import Place
from app.object_store.publishing import read_text, write_text
from razer.errors import BadInput
from razer.files import parse_json

FORMAT = 1
REPORT, LOGS = "report.json", "batch_logs"
Status = Literal["done", "failed", "unfinished"]
_MAX_ROWS = 40


@dataclass
class SceneRecord:
    """What became of a scene: of all its attempts, and of the last one."""

    name: str
    status: Status = "unfinished"
    attempts: int = 0
    seconds: float = 0.0
    cpu_s: float = 0.0
    peak_mb: float = 0.0
    node: str = ""
    reason: str = ""
    history: list[dict[str, Any]] = field(default_factory=list)

    def add(self, outcome: Outcome) -> None:
        """Take in an attempt that ended."""
        self.attempts += 1
        self.seconds += round(outcome.seconds, 2)
        self.cpu_s += round(outcome.cpu_s, 2)
        self.peak_mb = max(self.peak_mb, round(outcome.peak_mb, 1))
        self.node, self.reason = outcome.node, outcome.reason
        if outcome.is_done:
            self.status = "done"
        log = f"{LOGS}/{self.name}.{self.attempts}.log" if outcome.log else None
        entry = {"seconds": round(outcome.seconds, 2), "node": outcome.node, "reason": outcome.reason, "log": log}
        self.history.append(entry | ({"not_evaluated": outcome.no_result} if outcome.no_result else {}))


@dataclass
class BatchReport:
    """`report.json` of a batch (format 1). settings: what its runs were asked for; one that goes on has the same."""

    out: Place
    settings: Mapping[str, Any]
    scenes: dict[str, SceneRecord]
    totals: dict[str, Any] = field(default_factory=dict)

    def add(self, outcome: Outcome) -> None:
        """Take in an attempt, and keep its log."""
        record = self.scenes[outcome.name]
        record.add(outcome)
        if log := record.history[-1]["log"]:
            self._write(log, outcome.log)

    @property
    def n_failed(self) -> int:
        """How many scenes have no result after all attempts."""
        return sum(record.status == "failed" for record in self.scenes.values())

    def write(self) -> None:
        """Write it, in one go."""
        self._write(REPORT, json.dumps(self.as_json(), indent=1) + "\n")

    def as_json(self) -> dict[str, Any]:
        """Everything as plain JSON values."""
        records = self.scenes.values()
        counts = {status: sum(one.status == status for one in records) for status in ("done", "failed", "unfinished")}
        sums = {"cpu_s": round(sum(one.cpu_s for one in records), 2), "attempts": sum(one.attempts for one in records)}
        totals = {"scenes": len(records), **counts, **sums, **self.totals}
        scenes = [vars(one) for one in records]
        return {"format": FORMAT, "settings": dict(self.settings), "scenes": scenes, "totals": totals}

    def _write(self, name: str, text: str) -> None:
        place = self.out / name
        if not place.is_remote:
            place.path.parent.mkdir(parents=True, exist_ok=True)
        write_text(place, text)


def begun_report(out: Place, settings: Mapping[str, Any], scenes: Mapping[str, bool], *, resume: bool) -> BatchReport:
    """The report of a batch that begins, or goes on with what an earlier one left.

    Args:
        out: where it goes.
        settings: what the runs are asked for.
        scenes: by name, whether their map is there.
        resume: go on with a batch that is there.

    Raises:
        BadInput: where a batch is there and is not to be resumed, or was made with other settings, and where maps are
            there that are of no batch.
    """
    report = BatchReport(out, settings, {name: SceneRecord(name) for name in scenes})
    text = read_text(out / REPORT)
    if text is None:
        if others := [name for name, is_there in scenes.items() if is_there]:
            raise BadInput(f"{out / others[0]} is there, and of no batch: choose another place with -o")
        return report
    if not resume:
        raise BadInput(f"{out} holds a batch: go on with it by --resume, or choose another place with -o")
    old = parse_json(text, str(out / REPORT))
    if not isinstance(old, dict) or old.get("format") != FORMAT:
        raise BadInput(f"{out / REPORT} is no report of a batch")
    if old.get("settings") != json.loads(json.dumps(dict(settings))):
        raise BadInput(f"{out} was begun with other options of razer run: give the same, or another place with -o")
    for entry in old.get("scenes", ()):
        if isinstance(entry, dict) and (name := entry.get("name")) in report.scenes:
            report.scenes[name] = _record(entry, str(out / REPORT))
    for name, record in report.scenes.items():
        record.status = "done" if scenes[name] else "unfinished"
        record.reason = "" if scenes[name] else record.reason
    return report


def _record(entry: dict[str, Any], where: str) -> SceneRecord:
    blank = vars(SceneRecord(""))
    if entry.keys() != blank.keys() or any(not _is_like(entry[name], value) for name, value in blank.items()):
        raise BadInput(f"{where}: an entry of a scene is damaged")
    return SceneRecord(**entry)


def _is_like(value: object, other: object) -> bool:
    """Whether a value is of the type of another; whole numbers pass for others."""
    return isinstance(value, (int, float) if isinstance(other, float) else type(other))


def print_report(report: BatchReport, console: Console) -> None:
    """A table of the scenes, those that failed first."""
    table = Table(title=f"{len(report.scenes)} scenes", title_justify="left")
    for name in ("scene", "status"):
        table.add_column(name)
    for name in ("attempts", "seconds", "CPU s", "peak MB"):
        table.add_column(name, justify="right")
    table.add_column("node")
    order = {"failed": 0, "unfinished": 1, "done": 2}
    records = sorted(report.scenes.values(), key=lambda one: order[one.status])
    for one in records[:_MAX_ROWS]:
        numbers = (str(one.attempts), f"{one.seconds:.1f}", f"{one.cpu_s:.1f}", f"{one.peak_mb:.0f}")
        table.add_row(one.name, one.status, *numbers, one.node)
    console.print(table)
    for one in records[:_MAX_ROWS]:
        if one.status != "done" and one.reason:
            log = next((entry["log"] for entry in reversed(one.history) if entry["log"]), None)
            console.print(f"{one.name}: {one.reason}" + (f" ({log})" if log else ""), soft_wrap=True)
    if len(records) > _MAX_ROWS:
        console.print(f"and {len(records) - _MAX_ROWS} more: {REPORT} has them all")
    totals = report.as_json()["totals"]
    console.print(
        f"{totals['done']} of {totals['scenes']} done, {totals['failed']} failed, {totals['unfinished']} unfinished; "
        f"{totals.get('seconds', 0):.1f} s, {totals['cpu_s']:.1f} s of processors",
        soft_wrap=True,
    )
