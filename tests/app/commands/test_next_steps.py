"""What a verb advises to do next works as it stands, and is a note: `--json` and `--quiet` are without it."""

from __future__ import annotations

import shlex

import pytest

from tests.support.cli import QUICK, instances_of, map_oracle_room, razer

LASTING = ("serve", "--web")  # until Ctrl-C: their own tests open them


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A recording with its truth, and its map, in a folder whose name a shell would split."""
    folder = tmp_path_factory.mktemp("next") / "my room"
    map_oracle_room(folder, 12, (160, 120))
    return folder


def advised(err: str) -> list[list[str]]:
    """The commands after `next:`, by their words after `razer`."""
    lines = err.splitlines()
    first = next(number for number, line in enumerate(lines) if line.startswith("next: "))
    commands = [shlex.split(line.removeprefix("next:")) for line in lines[first:]]
    assert all(command[0] == "razer" for command in commands)
    return [command[1:] for command in commands]


@pytest.mark.full
@pytest.mark.parametrize(
    "arguments",
    [
        ("inspect", "recording"),
        ("convert", "recording", "other", "--layout", "tum"),
        ("track", "recording", "-o", "path.txt", "--frames", "8"),  # where the camera is lost nearly always
        ("query", "run", "chair"),
        ("query", "run", "--render", "hits.png", "chair"),
        ("label", "run", "--vocabulary", "nyu40"),
        ("eval", "run", "--truth", "recording"),
        ("view", "run", "--picture", "map.png"),
        ("view", "run", "--page", "map.html"),
        ("edit", "run", "rename", "ID", "my thing"),
        ("edit", "run", "log"),
        ("bench", "recording", "--masks", "--oracle", "none", "--frames", "4"),
        ("synth", "rendered", "--scene", "tabletop", "--frames", "6", "--size", "160x120"),
    ],
    ids=lambda words: " ".join(words),
)
def test_what_is_advised_works(place, arguments, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(place)
    number = str(_first_id(place))
    words = [
        str(tmp_path / word) if word in ("other", "rendered") else word.replace("ID", number) for word in arguments
    ]
    code, _, err = razer(capsys, *words)
    assert code == 0, err
    for command in advised(err):
        if not any(word in LASTING for word in command):
            quick = QUICK if command[0] == "run" else ()
            assert razer(capsys, *command, *quick)[0] == 0, command


def _first_id(place) -> int:
    return min(entry["id"] for entry in instances_of(place / "run"))


def test_json_and_quiet_are_without_notes(place, capsys):
    _, out, err = razer(capsys, "edit", place / "run", "log", "--json")
    assert (out.count("\n"), err) == (1, "")
    _, _, err = razer(capsys, "edit", place / "run", "log", "--quiet")
    assert err == ""
    _, _, err = razer(capsys, "edit", place / "run", "log")
    assert advised(err)
