"""The commands that one copies from a page do what it says: they are executed, page by page, on a small recording."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from scipy.spatial import cKDTree

from app.frames.selection import Selection
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording
from razer import load_map
from tests.support.cli import QUICK, call
from tests.support.page_commands import PAGES, ROOT, block_lines, words
from tests.support.pose_files import write_colmap

NETWORK, WEIGHTS = "needs the network", "needs the weights of starter"
MODEL_FILES, LONG = "needs files of models that are no part of the project", "takes an hour"
EXECUTED = (
    "README",
    "first_recording",
    "no_poses",
    "which_models",
    "compare_poses",
    "python",
    "when_it_goes_wrong",
    "page",
    "pictures",
    "edits",
    "evaluation",
    "queries",
    "synthetic",
)
LEFT_OUT = {
    "make demo": NETWORK,
    "pip install 'razer[transformers]'": NETWORK,
    "razer models pull starter": NETWORK,
    "razer run FOLDER -o NAMED --stride 5": WEIGHTS,
    'razer query NAMED "something to sit on"': WEIGHTS,
    'razer query OUT "something to sit on"': WEIGHTS,
    "razer label NAMED --vocabulary coco": WEIGHTS,
    'razer edit NAMED rename 12 "office chair"': WEIGHTS,
    "razer view OUT": "needs a display",
    "razer reproduce scenenn DATA -o OUT": "needs a dataset",
    "razer ablate --seeds 0,1 --frames 300": LONG,
    "razer ablate --seeds 0,1 --stride 1,3,6": LONG,
    "razer run FOLDER -o RUN --vocabulary scannet200": WEIGHTS,
    "razer run W -o RUN --stride 3 --oracle detector --set embedder.options.table=LVIS.npz "
    "--set embedder.options.seed=90 --set segmenter.options.seed=90": MODEL_FILES,
    "razer eval RUN --truth W --names text --json": "is of the run before it",
    "razer ablate --naming RUN RUN ...": "stands for as many runs as one has",
    "razer bench A71 --recognition --segmenter yolo --set segmenter.options.weights=yolo11n-seg.onnx": MODEL_FILES,
    "razer bench A71 --recognition --segmenter semantic "
    "--set segmenter.options.weights=mosaic-r3-ade31.onnx": MODEL_FILES,
    "razer run FOLDER -o OWN --segmenter my_module:DarkThings": "my_module is the reader's own",
}
# The others go through the program's parser (test_commands.py), and what they do is tried by the verbs' own tests.
PAGES_LEFT_OUT = {
    "verbs": "it needs a run that was killed: tests/app/commands/test_run_resume.py",
    "server": "serves until Ctrl-C: tests/app/server asks a real one",
    "batch": "needs a folder of recordings, a cluster, a store: tests/app/batch runs the verb",
    "scale": "simulates a batch that is made first: tests/app/commands/test_batch_simulate.py",
    "library": "asks by pictures, which needs a model: tests/app/library asks the verb",
    "pose_benchmark": "takes eleven minutes: tests/app/commands/test_bench_poses.py runs short walks",
    "timeline": "needs a display, or serves until Ctrl-C: tests/app/timeline/viewer opens it",
}
# What these pages call finished runs.
HAVE_A_RUN = {
    "page": ("OUT",),
    "pictures": ("RUN",),
    "edits": ("OUT",),
    "evaluation": ("RUN_A", "RUN_B", "RUNS/one"),
    "queries": ("RUN",),
}
# And what they call the recording, or its truth.
HAVE_A_TRUTH = {"evaluation": ("SCENES/one", "SCAN")}
SCAN = "scene0000_00_vh_clean_2.ply"
SMALL = ("--frames", "8", "--size", "160x120")  # of what is rendered here
WRITES = ("-o", "--page", "--picture")
N_FRAMES, EVERY, SIZE = 24, 3, (160, 120)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Neighbouring views of a walk through the synthetic room, with poses and truth: what pages call FOLDER."""
    room = SyntheticRoom(0, 240, *SIZE)
    start = Selection.of(room, range(0, EVERY * N_FRAMES, EVERY), Console(quiet=True))
    folder = tmp_path_factory.mktemp("page") / "FOLDER"
    write_recording(start, folder, truth=room.truth(0.05), lossless=True)
    return folder


@pytest.fixture(scope="module")
def finished_run(recording):
    """The map of that recording with the simulator's masks and names."""
    run = recording.with_name("run")
    assert call("run", recording, "-o", run, "--oracle", "full", "--no-timeline", *QUICK) == 0
    return run


def lines_of(name: str) -> list[str]:
    """The shell lines of a page."""
    (page,) = (page for page in PAGES if page.stem == name)
    return block_lines(page)


def is_left_out(line: str) -> bool:
    return any(words(line) == words(known) for known in LEFT_OUT)


def execute(arguments: list[str]) -> int:
    """The exit code of a line that calls the program, or Python with one of the examples."""
    if Path(arguments[0]).name == "razer":
        return call(*arguments[1:])
    assert arguments[0] == "python", f"this test knows no {arguments[0]}"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(ROOT / arguments[1]), *arguments[2:]]
    return subprocess.run(command, env=environment, check=False).returncode


@pytest.mark.full
@pytest.mark.parametrize("name", EXECUTED)
def test_the_commands_of_a_page_work_one_after_the_other(name, recording, tmp_path, monkeypatch, request):
    shutil.copytree(recording, tmp_path / "FOLDER")
    for place in HAVE_A_RUN.get(name, ()):
        shutil.copytree(request.getfixturevalue("finished_run"), tmp_path / place)
    for place in HAVE_A_TRUTH.get(name, ()):
        shutil.copytree(recording, tmp_path / place)
    (tmp_path / "list.txt").write_text("one\n")
    names = sorted(file.name for file in (recording / "color").iterdir())
    write_colmap(tmp_path / "images.txt", names, SyntheticRoom(0, 240, *SIZE).poses[: EVERY * N_FRAMES : EVERY])
    for file in ("mesh.ply", "classes.json"):
        shutil.copy(recording / "truth" / file, tmp_path / (SCAN if file == "mesh.ply" else file))
    monkeypatch.chdir(tmp_path)
    numbers = numbers_on(Path("OUT")) if name == "edits" else {}
    for line in lines_of(name):
        if is_left_out(line):
            continue
        for arguments in parts_of(line):
            assert execute([numbers.get(word, word) for word in small(arguments)]) == 0, line
            for option, target in pairwise(arguments):
                assert option not in WRITES or Path(target).exists(), line


def parts_of(line: str) -> list[list[str]]:
    """The commands of a line, one after the other."""
    return [list(group) for key, group in groupby(words(line), lambda word: word == "&&") if not key]


def small(arguments: list[str]) -> list[str]:
    """A command as it is, but of few and small frames where it renders a recording, into a folder that is new."""
    if arguments[1] != "synth":
        return arguments
    shutil.rmtree(arguments[2], ignore_errors=True)
    kept = [word for before, word in pairwise(["", *arguments]) if "--frames" not in (before, word)]
    return [*kept, *SMALL]


def numbers_on(run: Path) -> dict[str, str]:
    """Ids of a run that the edits of the page can be made of, by the ids on the page."""
    panoptic = load_map(run)
    points = {item.id: panoptic.mesh.vertices[panoptic.mesh.instances == item.id] for item in panoptic.objects}
    floors = [item.id for item in panoptic.objects if item.class_name == "floor"]
    floor = max(floors, key=lambda number: len(points[number]))
    near_floor = cKDTree(points[floor])
    walls = [item.id for item in panoptic.objects if item.class_name == "wall" and (points[item.id][:, 2] < 0.1).any()]
    wall = min(walls, key=lambda number: near_floor.query(points[number])[0].min())
    shares = {item.id: np.mean(points[item.id][:, 0] >= 0.3) for item in panoptic.objects if not item.is_stuff}
    split = min(shares, key=lambda number: abs(shares[number] - 0.5))  # half of it lies on either side of the plane
    others = [str(number) for number in shares if number != split]
    numbers = dict(zip(("12", "31", "6", "9", "14", "10"), others, strict=False))
    return numbers | {"1": str(split), "2": str(wall), "3": str(floor)}


def test_each_page_with_commands_is_executed_or_left_out_for_a_reason():
    with_commands = {page.stem for page in PAGES if block_lines(page)}
    assert with_commands == {*EXECUTED, *PAGES_LEFT_OUT}


@pytest.mark.parametrize("name", EXECUTED)
def test_a_page_that_is_executed_has_commands_that_are_not_left_out(name):
    assert any(not is_left_out(line) for line in lines_of(name))


def test_what_is_left_out_is_on_a_page():
    lines = [words(line) for name in EXECUTED for line in lines_of(name)]
    assert [known for known in LEFT_OUT if words(known) not in lines] == []
