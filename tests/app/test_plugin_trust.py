"""Data chooses no code: plug-ins that files name are refused by every verb, those that the command line names load."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from app.frames.selection import Selection
from app.settings.config_file import read_config
from data_tools import open_sequence
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording
from razer.errors import BadInput
from razer.models import make_embedder, make_segmenter
from razer.plugins import FULL_TRUST, NO_TRUST, Trust, load
from tests.support.cli import QUICK, contents, map_oracle_room, razer

SIZE = (160, 120)
EMBEDDERS = {  # each of them leaves its mark if it is ever imported or made
    "function": 'name = "os:system"\n[embedder.options]\ncommand = "touch {mark}"',
    "class": 'name = "planted:Embedder"\n[embedder.options]\nmark = "{mark}"',
    "nested": 'name = "names"\n[embedder.options]\nembedder = "planted:Embedder"\nembedder_options.mark = "{mark}"',
    "subprocess": 'name = "subprocess:Popen"\n[embedder.options]\nargs = ["touch", "{mark}"]',
    "ours, but no part": 'name = "tests.planted:Embedder"\n[embedder.options]\nmark = "{mark}"',
}
SEGMENTERS = {
    "function": 'name = "os:system"\n[segmenter.options]\ncommand = "touch {mark}"',
    "class": 'name = "planted:Segmenter"\n[segmenter.options]\nmark = "{mark}"',
    "joined": 'name = "geometric+planted:Segmenter"\n[segmenter.options]\nSegmenter.mark = "{mark}"',
    "nested": 'name = "sam"\n[segmenter.options]\nboxes = "os:system"\nboxes_options.command = "touch {mark}"\n'
    'weights = "{weights}"',
}
PLANTED = """
from pathlib import Path

import numpy as np

from razer.frame import Masks

class Segmenter:
    def __init__(self, mark):
        Path(mark).touch()

    def segment(self, frame):
        return Masks.none(*frame.depth.shape)

class Embedder:
    def __init__(self, mark):
        Path(mark).touch()

    def embed(self, frame, masks):
        return np.zeros((len(masks), 4), np.float32)

    def embed_texts(self, texts):
        return np.tile(np.eye(4, dtype=np.float32)[0], (len(texts), 1))

class Neither:
    def __init__(self, mark):
        Path(mark).touch()

def read(folder, declared, use_poses):
    raise RuntimeError("the planted reader ran")
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(run, recording) of a small room with perfect masks."""
    return map_oracle_room(tmp_path_factory.mktemp("room"), 8, SIZE)


@pytest.fixture
def run(made, tmp_path):
    return shutil.copytree(made[0], tmp_path / "run")


@pytest.fixture
def mark(tmp_path, monkeypatch):
    """What planted code would touch; the code can be imported."""
    (tmp_path / "planted.py").write_text(PLANTED)
    monkeypatch.syspath_prepend(str(tmp_path))
    sys.modules.pop("planted", None)
    yield tmp_path / "mark"
    sys.modules.pop("planted", None)


def plant(run, section, text, mark):
    """Put a plug-in into a run folder's settings, and take the classes away, so that `eval` needs the embedder."""
    config = run / "config.toml"
    head, _, rest = config.read_text().partition(f"[{section}]\n")
    rest = rest[rest.find("\n[") + 1 :] if "\n[" in rest else ""
    while rest.startswith(f"[{section}."):
        rest = rest[rest.find("\n[") + 1 :] if "\n[" in rest else ""
    filled = text.format(mark=mark, weights=mark.parent)
    config.write_text(f"{head}[{section}]\n{filled}\n{rest}")
    read_config(config, (), {})  # the settings as such are sound
    listed = json.loads((run / "instances.json").read_text())
    listed["instances"] = [entry | {"class": None} for entry in listed["instances"]]
    (run / "instances.json").write_text(json.dumps(listed))


def assert_refused(code, out, err, mark):
    assert code == 2, err
    assert not mark.exists()
    assert "planted" not in sys.modules
    assert out == ""
    assert "Traceback" not in err
    messages = [line for line in err.splitlines() if line.startswith("razer:")]
    assert len(messages) == 1
    assert "--trust-plugins" in messages[0]


@pytest.mark.parametrize("plant_of", EMBEDDERS)
@pytest.mark.parametrize("verb", ["query", "query image", "label", "eval", "eval text", "compare"])
def test_an_embedder_planted_in_a_run_folder_is_refused(capsys, made, run, mark, verb, plant_of):
    plant(run, "embedder", EMBEDDERS[plant_of], mark)
    before = contents(run)
    recording = made[1]
    picture = next((recording / "color").iterdir())
    commands = {
        "query": ("query", run, "a chair"),
        "query image": ("query", run, "--image", picture),
        "label": ("label", run, "--vocabulary", "coco"),
        "eval": ("eval", run, "--truth", recording),
        "eval text": ("eval", run, "--truth", recording, "--names", "text"),
        "compare": ("compare", made[0], run, "--truth", recording),
    }
    assert_refused(*razer(capsys, *commands[verb]), mark)
    assert contents(run) == before


def of_settings_files():
    """Verbs and what a file has; those that start further processes or are slow to begin with all of it in full."""
    planted = [("embedder", kind, text) for kind, text in EMBEDDERS.items()]
    planted += [("segmenter", kind, text) for kind, text in SEGMENTERS.items()]
    planted += [("input", "class", 'reader = "planted:read"')]
    for verb in ("run", "reproduce", "bench"):
        for section, kind, text in planted:
            is_quick = verb == "run" or (verb == "reproduce" and kind == "class")
            yield pytest.param(verb, section, text, marks=[] if is_quick else [pytest.mark.full])


@pytest.mark.parametrize(("verb", "section", "text"), [*of_settings_files()])
def test_a_plug_in_that_a_settings_file_names_is_refused(capsys, made, mark, tmp_path, verb, section, text):
    file = tmp_path / "settings.toml"
    file.write_text(f"[{section}]\n{text.format(mark=mark, weights=tmp_path)}\n")
    out = tmp_path / "out"
    data = tmp_path / "data"
    shutil.copytree(made[1], data / "room0")
    commands = {
        "run": ("run", made[1], "-o", out, "--config", file, *QUICK, "--no-timeline"),
        "bench": ("bench", made[1], "--config", file, "--max-frames", 2, "--device", "cpu"),
        "reproduce": ("reproduce", "replica", data, "--scenes", "room0", "--out", out, "--config", file),
    }
    code, _, err = razer(capsys, *commands[verb])
    assert code == 2, err
    assert not mark.exists()
    assert "planted" not in sys.modules
    assert "Traceback" not in err
    assert "--trust-plugins" in err
    assert not (out / "instances.json").exists()


def test_the_demo_takes_its_own_models_whatever_a_file_names(capsys, mark, tmp_path):
    file = tmp_path / "settings.toml"
    file.write_text('[embedder]\nname = "os:system"\n[voxels]\nvoxel_size_m = 0.05\n')
    assert razer(capsys, "demo", "-o", tmp_path / "out", "--frames", 4, "--config", file)[0] == 0
    assert not mark.exists()


@pytest.mark.parametrize("verb", ["config", "track", "inspect", "convert", "view"])
def test_verbs_that_need_no_plug_in_do_not_load_one(capsys, made, run, mark, tmp_path, verb):
    plant(run, "embedder", EMBEDDERS["class"], mark)
    commands = {
        "config": ("config", "--config", run / "config.toml"),
        "track": ("track", made[1], "-o", tmp_path / "path.txt", "--max-frames", 3),
        "inspect": ("inspect", run),
        "convert": ("convert", run, tmp_path / "out"),
        "view": ("view", run, "--picture", tmp_path / "picture.png"),
    }
    razer(capsys, *commands[verb])
    assert not mark.exists()
    assert "planted" not in sys.modules


def test_what_the_command_line_names_is_loaded(capsys, run, mark):
    options = ("--set", f"embedder.options.mark={mark}")
    _, _, err = razer(capsys, "query", run, "a chair", "--embedder", "planted:Embedder", *options, "--json")
    assert mark.exists(), err


def test_trust_plugins_loads_what_a_run_folder_names(capsys, run, mark):
    plant(run, "embedder", EMBEDDERS["class"], mark)
    razer(capsys, "query", run, "a chair", "--trust-plugins")
    assert mark.exists()


def test_naming_one_plug_in_trusts_no_other(capsys, run, mark):
    plant(run, "embedder", EMBEDDERS["nested"], mark)
    code, _, _ = razer(capsys, "query", run, "a chair", "--set", "voxels.voxel_size_m=0.02")
    assert code == 2
    assert not mark.exists()


@pytest.mark.parametrize("make", [make_segmenter, make_embedder])
@pytest.mark.parametrize("name", ["os:system", "builtins:eval", "planted:Neither", "planted:read"])
def test_a_part_is_a_class_with_the_methods_of_its_protocol(mark, make, name):
    with pytest.raises(BadInput, match="is no class with the method"):
        make(name, {"mark": str(mark)}, FULL_TRUST)
    assert not mark.exists()


def test_a_reader_from_outside_needs_trust(mark, made):
    with pytest.raises(BadInput, match="trust-plugins"):
        open_sequence(made[1], reader="planted:read")
    with pytest.raises(RuntimeError, match="the planted reader ran"):
        open_sequence(made[1], reader="planted:read", trust=Trust(frozenset({"planted:read"})))


@pytest.mark.parametrize("name", ["os:", ":system", ":", "os:system:more", "os\n:system", "..os:system", "\0:x"])
def test_names_that_can_be_none_are_one_plain_line(name):
    for trust in (NO_TRUST, FULL_TRUST):
        with pytest.raises(BadInput):
            load("segmenter", name, {}, {}, methods=["segment"], trust=trust)


@pytest.mark.full
def test_the_embedder_that_the_command_line_names_also_compares_the_runs_under_both_poses(capsys, mark, tmp_path):
    room = SyntheticRoom(0, 120, 320, 240)
    start = Selection(room, range(8), iter(()))  # near enough to each other to be tracked
    write_recording(start, tmp_path / "recording", truth=room.truth(0.05), lossless=True)
    models = ("--embedder", "planted:Embedder", "--set", f"embedder.options.mark={mark}")
    out = tmp_path / "both"
    options = ("--poses", "both", "--no-timeline", *models, *QUICK)
    code, _, err = razer(capsys, "run", tmp_path / "recording", "-o", out, *options)
    assert code == 0, err
    comparison = json.loads((out / "compare" / "compare.json").read_text())
    assert comparison["a"]["class_agnostic"] is not None
    assert mark.exists()


def test_a_reader_planted_in_a_run_folder_ends_the_query(capsys, run, mark, tmp_path):
    config = run / "config.toml"
    config.write_text(config.read_text().replace("[input]\n", '[input]\nreader = "planted:read"\n'))
    assert_refused(*razer(capsys, "query", run, "a chair"), mark)


def test_what_lies_in_the_working_directory_is_not_imported(made, tmp_path):
    """Helper processes start with the working directory on their path unless they are told not to."""
    place, program = tmp_path / "downloaded", tmp_path / "program.py"
    place.mkdir()
    for module in ("pickle", "signal", "selectors"):
        (place / f"{module}.py").write_text(f"open({str(tmp_path / 'mark')!r}, 'w')\nraise SystemExit(3)\n")
    program.write_text(
        "from app.__main__ import program\n\nif __name__ == '__main__':\n    program()\n"
    )  # as pip installs it
    command = [sys.executable, program, "run", made[1], "-o", tmp_path / "out", "--max-frames", "2", *QUICK]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    done = subprocess.run([str(part) for part in command], cwd=place, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "mark").exists()


def test_a_message_is_one_line_without_commands_for_the_terminal(capsys, run, mark, tmp_path):
    file = tmp_path / "settings.toml"
    file.write_text('[segmenter]\nname = "planted:Segmenter\\nrazer: all is well\\u001b[2J"\n')
    code, _, err = razer(capsys, "run", tmp_path, "-o", tmp_path / "out", "--config", file)
    assert code == 2
    assert len(err.splitlines()) == 1
    assert "\x1b" not in err
