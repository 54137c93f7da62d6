"""The measurement of `razer bench --recognition`: what a segmenter recognises, against the recording's instance ids."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

from rich.table import Table

from app.console.progress import show_progress
from app.console.streams import progress_console, result_console
from app.frames.selection import selected_frames
from app.mask_quality.opened_recording import opened
from app.mask_quality.recognition import Recognition
from app.settings.run_config import RunConfig
from razer.errors import BadInput, UnusableFrame
from razer.models.recorded_view import masks_of

FORMAT = 1


def measure_recognition(folder: Path, config: RunConfig) -> dict[str, Any]:
    """Recall and IoU over the frames that the settings choose, format 1 of `bench --recognition --json`; raises
    BadInput."""
    console = progress_console()
    sequence, segmenter, name = opened(folder, config, console)
    recognition = Recognition()
    indices = selected_frames(sequence, config.input)
    for index in show_progress(indices, len(indices), lambda: "recognition", console, first="the first frame"):
        with suppress(UnusableFrame):
            frame = sequence[index]
            if frame.instance_ids is None:
                raise BadInput(f"{folder} has no instance ids: --recognition needs a recording with a truth")
            recognition.add(frame, masks_of(segmenter, frame))
    return {"format": FORMAT, "name": sequence.name, "segmenter": name} | recognition.to_json()


def print_recognition(result: dict[str, Any]) -> None:
    """The figures as a table."""
    title = f"{result['name']}: {result['segmenter']}, {result['frames']} frames"
    table = Table(title=title, title_justify="left")
    for column in ("thing", "seen", "found", "recall"):
        table.add_column(column, justify="left" if column == "thing" else "right")
    for name, one in result["things"].items():
        if one["seen"]:
            table.add_row(name, str(one["seen"]), str(one["found"]), _share(one["found"] / one["seen"]))
    table.add_section()
    table.add_row("all of them", *(str(_sum(result, key)) for key in ("seen", "found")), _share(result["recall"]))
    table.add_section()
    for name, iou in result["surfaces"].items():
        table.add_row(f"IoU of {name}", "", "", _share(iou))
    table.add_row("mIoU", "", "", _share(result["miou"]))
    result_console().print(table)


def _sum(result: dict[str, Any], key: str) -> int:
    return sum(one[key] for one in result["things"].values())


def _share(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.1f} %"
