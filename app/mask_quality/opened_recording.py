"""A segmenter and the recording on which it is measured."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from app.console.waiting import waiting_for
from app.frames.open_recording import open_recording
from app.pipeline.prepare_run import print_model_note, resolve_models
from app.settings.run_config import RunConfig
from data_tools.recordings.sequence import RgbdSequence
from razer.models import Segmenter, make_segmenter


def opened(folder: Path, config: RunConfig, console: Console) -> tuple[RgbdSequence, Segmenter, str]:
    """The recording, the segmenter that the settings choose, and its name; raises BadInput."""
    config, note = resolve_models(config)
    chosen = config.segmenter
    with waiting_for("loading the segmenter", console):
        segmenter = make_segmenter(chosen.name, chosen.options, chosen.trust)
    sequence = open_recording(folder, config.input, console)
    print_model_note(note, console)
    return sequence, segmenter, chosen.name
