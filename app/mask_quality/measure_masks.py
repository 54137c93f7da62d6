"""The measurement of `razer bench --masks`: how consistent a segmenter's masks are over a recording."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from app.console.progress import show_progress
from app.console.streams import progress_console, result_console
from app.frames.cameras.color_registration import register_color
from app.frames.open_recording import require_poses
from app.frames.selection import selected_frames
from app.mask_quality.mask_consistency import MaskConsistency, View
from app.mask_quality.opened_recording import opened
from app.settings.run_config import RunConfig
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import UnusableFrame
from razer.models.recorded_view import masks_of

FORMAT = 1


def measure_masks(folder: Path, config: RunConfig) -> dict[str, Any]:
    """The statistics of the masks of the frames that the settings choose, format 1 of `bench --masks --json`; raises
    BadInput."""
    console = progress_console()
    sequence, segmenter, name = opened(folder, config, console)
    require_poses(sequence)
    statistics = MaskConsistency.of(_views(sequence, config, partial(masks_of, segmenter), console))
    return {"format": FORMAT, "name": sequence.name, "segmenter": name} | statistics.to_json()


def _views(sequence: RgbdSequence, config: RunConfig, segment: Any, console: Console) -> Iterator[View]:
    warp = register_color(sequence, config.input.rgbd_calibration, console).warp
    indices = selected_frames(sequence, config.input)
    for index in show_progress(indices, len(indices), lambda: "masks", console, first="the first frame"):
        with suppress(UnusableFrame):
            frame = sequence[index]
            if frame.world_from_camera is not None:
                registered = frame if warp is None else warp.registered(frame)
                yield View(registered, segment(registered))


def print_masks(result: dict[str, Any]) -> None:
    """The statistics as a table."""
    table = Table(title=f"{result['name']}: {result['segmenter']}", title_justify="left", show_header=False)
    table.add_column("what")
    table.add_column("value", justify="right")
    rows = [
        ("views", str(result["views"])),
        ("masks a view", f"{result['masks_a_view']:.1f}"),
        ("of a view seen in the next", _share(result["seen_again"])),
        ("masks compared", str(result["compared"])),
        ("missed in the next view", _share(result["missed"])),
        *((f"  of {_size(one)}", _share(one["missed"])) for one in result["missed_by_size"]),
        ("once missed, missed again", _share(result["missed_again"])),
        ("with another name", _share(result["renamed"])),
        ("IoU of the others", "-" if result["iou"] is None else f"{result['iou']:.3f}"),
    ]
    for name, value in rows:
        table.add_row(name, value)
    result_console().print(table)


def _share(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.1f} %"


def _size(one: dict[str, Any]) -> str:
    return f"{one['from_px']} px and more" if one["to_px"] is None else f"{one['from_px']} to {one['to_px']} px"
