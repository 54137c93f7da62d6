"""What an edit came too late for: somebody else changed its instances since its author looked."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from razer.edits.edit import Delete, Merge, MoveBorder, Relabel, Rename, Split
from razer.edits.log import EditLog, Entry, Reversal
from razer.errors import BadInput, EditConflict


def refuse_stale(log: EditLog, epoch: int, touched: Collection[int]) -> None:
    """Raise EditConflict where an instance was touched after an epoch, saying by which edit, the last one; BadInput for
    an epoch that is none of the log."""
    if not 0 <= epoch <= log.epoch:
        raise BadInput(f"epoch {epoch} is none of this map, which is at {log.epoch}: load it anew")
    for entry in reversed(log.entries[epoch:]):
        changed = log.entry(entry.change.edit) if isinstance(entry.change, Reversal) else entry
        if common := [i for i in touched if i in changed.touched]:
            raise EditConflict(f"{what_happened(log, entry, common[0])} since you looked: load the map anew")


def refuse_missing(log: EditLog, number: int) -> None:
    """Raise BadInput for an instance that an edit took away, saying which."""
    for entry in reversed(log.in_force):
        took = entry.touched[1:] if isinstance(entry.change, Merge) else entry.touched
        if isinstance(entry.change, Merge | Delete) and number in took:
            raise BadInput(what_happened(log, entry, number))


def what_happened(log: EditLog, entry: Entry, instance: int) -> str:
    """What an entry did to one of its instances: "chair #12 was merged into #7 by edit 4"."""
    change = entry.change
    if isinstance(change, Reversal):
        done = "was undone" if change.kind == "undo" else "was done again"
        return f"edit {change.edit} of {log.entry(change.edit).called(instance)} {done} by edit {entry.number}"
    return f"{entry.called(instance)} {_past(entry, instance)} by edit {entry.number}"


def account(log: EditLog, entry: Entry) -> str:
    """What an entry did: "chair #12 was merged into #7"."""
    if isinstance(entry.change, Reversal):
        return f"edit {entry.change.edit} was {'undone' if entry.kind == 'undo' else 'done again'}: " + account(
            log, log.entry(entry.change.edit)
        )
    first = entry.touched[0]
    return f"{entry.called(first)} {_past(entry, first)}"


def _past(entry: Entry, instance: int) -> str:
    match entry.change:
        case Rename(name=name) | Relabel(class_name=name):
            return f"was named {name}"
        case Merge(instances=[kept, *others]):
            return f"was merged into #{kept}" if instance != kept else f"took in {_numbers(others)}"
        case Delete():
            return "was deleted"
        case Split(new=new):
            return f"was split, into itself and #{new}" if instance != new else "was split off"
        case MoveBorder(source=source, target=target):
            return f"gave surface to #{target}" if instance == source else f"took surface of #{source}"
    return "was changed"


def _numbers(ids: Sequence[int]) -> str:
    return ", ".join(f"#{i}" for i in ids)
