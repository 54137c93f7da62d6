"""Faults planted in what verbs are given: each ends in one plain line with exit code 2, and leaves what was there."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.cli import contents, razer, write_small_room

RUN = Path(__file__).resolve().parent.parent / "fixtures" / "run_format_1"
Fault = Callable[[Path], object]
CAMERA, POSES = "in/intrinsics.json", "in/trajectory.txt"


def text(name: str, content: str | bytes) -> Fault:
    return lambda place: (place / name).write_bytes(content.encode() if isinstance(content, str) else content)


def edited(name: str, change: Callable[[bytes], bytes]) -> Fault:
    return lambda place: (place / name).write_bytes(change((place / name).read_bytes()))


def stated(**values: object) -> Fault:
    return edited(CAMERA, lambda data: json.dumps(json.loads(data) | values).encode())


def images(pattern: str, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Fault:
    def apply(place: Path) -> None:
        for path in place.glob(pattern):
            cv2.imwrite(str(path), change(cv2.imread(str(path), cv2.IMREAD_UNCHANGED)))

    return apply


def gone(name: str) -> Fault:
    return lambda place: shutil.rmtree(place / name) if (place / name).is_dir() else (place / name).unlink()


def in_place(name: str, make: Callable[[Path], object]) -> Fault:
    """Something else than a file where one was."""
    return lambda place: (gone(name)(place), make(place / name))


def folder(name: str) -> Fault:
    return in_place(name, Path.mkdir)


def pipe(name: str) -> Fault:
    return in_place(name, os.mkfifo)


def link(name: str, target: str) -> Fault:
    return in_place(name, lambda path: path.symlink_to(target))


def swapped(first: str, second: str) -> Fault:
    def apply(place: Path) -> None:
        (place / first).rename(place / "swapped")
        (place / second).rename(place / first)
        (place / "swapped").rename(place / second)

    return apply


def lines(change: Callable[[list[bytes]], list[bytes]]) -> Fault:
    return edited(POSES, lambda data: b"\n".join(change(data.splitlines())))


EVERY_DEPTH, EVERY_COLOUR = "in/depth/*.png", "in/color/*.png"
RECORDINGS: dict[str, tuple[Fault, str]] = {
    "no focal length": (stated(fx=0), "intrinsics.json: focal lengths must be positive"),
    "a negative focal length": (stated(fy=-5), "intrinsics.json: focal lengths must be positive"),
    "true for a number": (stated(fx=True), "focal lengths of 1"),
    "a camera that is null": (text(CAMERA, "null"), "intrinsics.json must be a JSON object"),
    "a camera that is a list": (text(CAMERA, "[160, 120]"), "intrinsics.json must be a JSON object"),
    "a camera that is a text": (text(CAMERA, '"pinhole"'), "intrinsics.json must be a JSON object"),
    "a camera that is a number": (text(CAMERA, "7"), "intrinsics.json must be a JSON object"),
    "the same key twice": (
        edited(CAMERA, lambda data: data.replace(b"{", b'{"width": 640, ', 1).replace(b"160", b"8")),
        "the intrinsics are for",
    ),
    "a bracket too many": (edited(CAMERA, lambda data: data + b"}"), "column 105 is not JSON"),
    "a comment in JSON": (edited(CAMERA, lambda data: b"// mm\n" + data), "line 1, column 1 is not JSON"),
    "a comma at the end": (edited(CAMERA, lambda data: data.replace(b"}", b",}")), "is not JSON"),
    "single quotes": (edited(CAMERA, lambda data: data.replace(b'"', b"'")), "is not JSON"),
    "not a number": (stated(cx=float("nan")), "the number NaN is not finite"),
    "too large a number": (edited(CAMERA, lambda data: data.replace(b"1000.0", b"1e400")), "1e400 is not finite"),
    "UTF-16": (edited(CAMERA, lambda data: data.decode().encode("utf-16")), "save it as UTF-8"),
    "another size": (stated(width=80), "the intrinsics are for 80x120 images"),
    "half a pixel": (stated(width=160.5), "width 160.5 is no whole number of pixels"),
    "no size": (stated(width=0), "0x120"),
    "three numbers of distortion": (stated(distortion=[0, 0, 0]), "five numbers k1,k2,p1,p2,k3"),
    "no depth scale": (stated(depth_scale=0), "the depth scale must be positive"),
    "a negative depth scale": (stated(depth_scale=-1000), "the depth scale must be positive"),
    "a folder for a camera": (folder(CAMERA), "intrinsics.json is a folder: give a file"),
    "a device for a camera": (link(CAMERA, "/dev/zero"), "intrinsics.json is a device: give a file"),
    "a pipe for a camera": (pipe(CAMERA), "intrinsics.json is a pipe: give a file"),
    "a link to itself": (link(CAMERA, "intrinsics.json"), "does not say what camera took it"),
    "an empty camera": (text(CAMERA, ""), "intrinsics.json cannot be read"),
    "no camera": (gone(CAMERA), "does not say what camera took it"),
    "stamps as dates": (
        lines(lambda rows: [b"2024-01-01T00:00:00 " + row.split(b" ", 1)[1] for row in rows]),
        "trajectory.txt, line 1: every line must read",
    ),
    "commas between numbers": (edited(POSES, lambda data: data.replace(b" ", b",")), "every line must read"),
    "commas for points": (edited(POSES, lambda data: data.replace(b".", b",")), "every line must read"),
    "a column too few": (lines(lambda rows: [row.rsplit(b" ", 1)[0] for row in rows]), "every line must read"),
    "a column too many": (lines(lambda rows: [row + b" 1" for row in rows]), "every line must read"),
    "a header that is no comment": (lines(lambda rows: [b"stamp x y z", *rows]), "every line must read"),
    "no pose": (text(POSES, ""), "trajectory.txt holds no pose"),
    "comments alone": (text(POSES, "# stamp tx ty tz\n"), "trajectory.txt holds no pose"),
    "no rotation": (text(POSES, "0 0 0 0 0 0 0 0\n1 0 0 0 0 0 0 0\n"), "the quaternion at 0.000000 has length 0"),
    "a long quaternion": (text(POSES, "0 0 0 0 0 0 0 5\n1 0 0 0 0 0 0 5\n"), "has length 5, not 1"),
    "a pose far away": (text(POSES, "0 1e300 0 0 0 0 0 1\n0.034 0 0 0 0 0 0 1\n"), "poses must be metres"),
    "poses of another time": (text(POSES, "-5 0 0 0 0 0 0 1\n-4 0 0 0 0 0 0 1\n"), "has no pose at 0.000000"),
    "a folder for poses": (folder(POSES), "trajectory.txt is a folder: give a file"),
    "a pipe for poses": (pipe(POSES), "trajectory.txt is a pipe: give a file"),
    "poses that link to themselves": (link(POSES, "trajectory.txt"), "trajectory.txt cannot be read"),
    "poses that are a picture": (text(POSES, b"\x89PNG\r\n\x1a\n\0\0"), "trajectory.txt cannot be read"),
    "depth of 8 bits": (images(EVERY_DEPTH, lambda d: (d >> 8).astype(np.uint8)), "depth must be a 16-bit PNG"),
    "depth in colour": (images(EVERY_DEPTH, lambda d: cv2.merge([d, d, d])), "has 3 channel(s) of uint16"),
    "depth with opacity": (images(EVERY_DEPTH, lambda d: cv2.merge([d, d, d, d])), "has 4 channel(s) of uint16"),
    "no depth": (images(EVERY_DEPTH, lambda d: d * 0), "holds no valid depth"),
    "depth that is full": (images(EVERY_DEPTH, lambda d: d * 0 + 65535), "holds no valid depth"),
    "no folder of depth": (gone("in/depth"), "has no known layout"),
    "a file for the folder of depth": (in_place("in/depth", Path.touch), "has no known layout"),
    "an empty folder of depth": (folder("in/depth"), "is missing"),
    "colour and depth swapped": (swapped("in/color", "in/depth"), "depth must be a 16-bit PNG"),
    "colour of one pixel": (images(EVERY_COLOUR, lambda c: c[:1, :1]), "colour is 1x1 but depth 160x120"),
    "no folder of colour": (gone("in/color"), "has no known layout"),
    "a folder that links to itself": (link("in/color", "color"), "has no known layout"),
    "a camera for a trajectory": (swapped(CAMERA, POSES), "intrinsics.json cannot be read"),
    "nothing": (folder("in"), "is empty"),
    "a file for a recording": (in_place("in", Path.touch), "in"),
    "a recording that links to itself": (link("in", "in"), "in"),
}


@pytest.fixture
def place(tmp_path: Path, small_room: Path) -> Path:
    """A recording and a run to spoil."""
    shutil.copytree(small_room, tmp_path / "in")
    shutil.copytree(RUN, tmp_path / "run")
    return tmp_path


@pytest.fixture(scope="module")
def small_room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_room(tmp_path_factory.mktemp("room") / "room", n_frames=2)


def ends_in_one_line(capsys: pytest.CaptureFixture[str], place: Path, arguments: str, said: str) -> None:
    """Both kinds of promise: one line, and nothing new or changed in the place."""
    before = contents(place) if not any(path.is_fifo() for path in place.rglob("*")) else None
    names = sorted(place.rglob("*"))
    words = [word.format(place=place) for word in arguments.split(" ")]
    code, out, err = razer(capsys, *words)
    assert (code, out) == (2, ""), err
    told = [line for line in err.splitlines() if line.startswith("razer")]
    assert told == err.splitlines()[-1:]
    assert said in told[0]
    assert "object" not in told[0].replace("JSON object", "")  # of Python's own words
    assert sorted(place.rglob("*")) == names
    assert before is None or contents(place) == before


@pytest.mark.parametrize("fault", RECORDINGS)
def test_a_recording_with_a_fault(capsys, place, fault):
    plant, said = RECORDINGS[fault]
    plant(place)
    ends_in_one_line(capsys, place, "convert {place}/in {place}/out", said)
    if not said.startswith("is missing"):
        assert razer(capsys, "inspect", place / "in")[0] != 0


WHOLE, EMPTY_PATH = "should be a whole number", "a path is empty"
OPTIONS: dict[str, str] = {
    **{f"synth {{place}}/out --frames={v}": WHOLE for v in ("1.5", "nan", "0x10", "1_000", "1e3", "\u0661", "", "a")},
    **{f"convert {{place}}/in {{place}}/out --stride={v}": WHOLE for v in ("1.5", "0x1", "1e0", "true")},
    **{f"query {{place}}/run chair -k={v}": WHOLE for v in ("1.5", "9" * 19, "0b1")},
    "track {place}/in --max-frames=1.5": WHOLE,
    "run {place}/in -o {place}/out --start=0.5": WHOLE,
    "bench --repeat=1.5": WHOLE,
    "ablate --frames=2.5": WHOLE,
    "serve {place}/run --port=1e3": WHOLE,
    "synth {place}/out --frames=-1": "--frames -1: give 0 to 1,000,000",
    "synth {place}/out --frames=1000001": "give 0 to 1,000,000",
    "synth {place}/out --seed=-1": "seed -1 is negative",
    **{f"synth {{place}}/out --size={v}": "write it as 640x480" for v in ("0x0", "640x", "-1x5", "640\u00d7480")},
    **{f"synth {{place}}/out --spacing={v}": "--spacing" for v in ("0", "-1", "nan", "1e400")},
    **{f"synth {{place}}/out --rgb-zoom={v}": "zoom" for v in ("0", "-1", "nan", "inf")},
    **{f"synth {{place}}/out --rgb-shift={v}": "shift" for v in ("nan,0", "a", "1e400,1", "0,0,0")},
    "synth {place}/out --layout=cube": "unknown layout 'cube'",
    "convert {place}/in {place}/out --stride=0": "input.stride = 0",
    "convert {place}/in {place}/out --stride=-1": "input.stride = -1",
    "convert {place}/in {place}/out --max-frames=0": "input.max_frames = 0",
    "convert {place}/in {place}/out --start=-1": "input.start = -1",
    **{f"convert {{place}}/in {{place}}/out --depth-scale={v}": "depth" for v in ("0", "-1", "nan", "1e400", "a")},
    **{f"config --set=voxels.voxel_size_m={v}": "voxels.voxel_size_m" for v in ("0", "-1", "nan", "1e400", "true")},
    **{f"config --set=input.max_frames={v}": "input.max_frames" for v in ("0", "-1", "1.5", "nan", "true")},
    "config --set=": "--set",
    "config --set=voxels": "voxels",
    "config --set=.=1": "unknown setting .",
    "config --preset=none": "none",
    "config --config=": EMPTY_PATH,
    "synth  --frames=1": EMPTY_PATH,
    "convert {place}/in ": EMPTY_PATH,
    "compare {place}/run {place}/run -o=": EMPTY_PATH,
    "query {place}/run --image=": EMPTY_PATH,
    **{f"query {{place}}/run chair --min-score={v}": "score" for v in ("-1", "1.5", "nan", "a")},
    "query {place}/run chair -k=0": "-k is at least 1",
    "query {place}/run": "give either a text to look for, or a picture",
    "query {place}/run chair --box=1,1,1,1": "--box is a part of the picture",
    "query {place}/run chair --image={place}/in/color/000000.png": "give either",
    **{f"edit {{place}}/run delete {v}": "is no id" for v in ("-1", "1.5", "nan", "\u0661x", "#", "a")},
    **{f"edit {{place}}/run delete {v}": "no instance" for v in ("99999", "2147483647")},
    "edit {place}/run delete 0": "instance: should be greater than or equal to 1",
    "edit {place}/run merge 7 7": "each instance is named once",
    "compare {place}/run {place}/run -o /": "/ cannot be written",
    "edit {place}/run rename 7": "write it as",
    "edit {place}/run undo 1": "write it as",
    "edit {place}/run undo": "undo",
    "edit {place}/run redo": "redo",
    "edit {place}/run log 1": "write it as",
    "edit {place}/run paint 1": "paint",
    **{f"edit {{place}}/run split 7 --plane={v}": "plane" for v in ("1,2,3", "a", "nan,0,0,0", "0,0,0,0")},
    **{f"view {{place}}/run --picture {{place}}/p.png --size={v}": "size" for v in ("0x0", "1e9", "99999x99999")},
    **{f"view {{place}}/run --picture {{place}}/p.png --angle={v}": "angle" for v in ("nan", "1", "a,b", "1e400,0")},
    "view {place}/run --picture {place}/p.txt": "give a .png",
    "view {place}/run --picture {place}/no/p.png": "give a .png in a folder that exists",
    "view {place}/run --style=query --picture {place}/p.png": "--style query shows what --query TEXT means",
    "view {place}/run --query=chair": "add --picture FILE.png",
    "convert {place}/in {place}/in": "exists: give a new folder",
    "convert {place}/in {place}/a/../in": "exists: give a new folder",
    "convert {place}/in {place}/in/": "exists: give a new folder",
    "convert {place}/in {place}/in/trajectory.txt/out": "cannot be written",
    "synth {place}/in --frames=1": "exists: give a new folder",
    "synth {place}/a/b/../../in --frames=1": "exists: give a new folder",
    "run {place}/in -o {place}/in": "exists; choose another folder",
    "run {place}/in -o {place}/in --overwrite": "is no run folder",
    "run {place}/in -o {place}/in/trajectory.txt --overwrite": "is not a folder",
    "run {place}/in -o / --overwrite": "/ cannot be written: choose another place",
    "run {place}/in": "--out needs a value",
    "run --resume {place}/run": "nothing to resume",
    "eval {place}/run --truth {place}/in -o {place}/run/mesh.ply": "give a folder for the plots",
    "eval --truth {place}/in": "give a run to evaluate",
    "label {place}/run --vocabulary=": "vocabulary",
    "label {place}/run --vocabulary={place}/in": "vocabulary",
    "label {place}/run --vocabulary={place}/run/map.npz": "map.npz",
    "config --config={place}/in": "is a folder: give a file",
    "config --config={place}/run/map.npz": "map.npz cannot be read",
    "config --config={place}/run/instances.json": "instances.json: not TOML",
    "ablate --seeds=1,a": "--seeds 1,a: give whole numbers",
    "ablate --stride=0": "--stride 0: give whole numbers from 1",
    "ablate --naming": "--naming needs finished runs",
    "bench --repeat=0": "--repeat 0: give at least 1",
    "models pull ../../etc": "../../etc",
}  # fmt: skip


@pytest.mark.parametrize("arguments", OPTIONS)
def test_arguments_that_cannot_be(capsys, place, arguments):
    ends_in_one_line(capsys, place, arguments, OPTIONS[arguments])


MAPS = ("instances.json", "mesh.ply", "embeddings.npz")
SPOILT: dict[str, Callable[[str], Fault]] = {
    "empty": lambda name: text(name, ""),
    "gone": gone,
    "a folder": folder,
    "a pipe": pipe,
    "a link to itself": lambda name: link(name, Path(name).name),
    "null": lambda name: text(name, "null"),
    "a picture": lambda name: text(name, b"\x89PNG\r\n\x1a\n"),
    "cut": lambda name: edited(name, lambda data: data[: len(data) // 2]),
    "another file": lambda name: lambda place: shutil.copy(place / "run/map.npz", place / name),
}


@pytest.mark.parametrize("verb", ["query {place}/run chair --json", "edit {place}/run delete 7 --json"])
@pytest.mark.parametrize("name", MAPS)
@pytest.mark.parametrize("fault", SPOILT)
def test_a_run_with_a_fault(capsys, place, verb, name, fault):
    SPOILT[fault](f"run/{name}")(place)
    ends_in_one_line(capsys, place, verb, "run")
