"""What SCENES names, by hand-made folders, lists and stores."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import fsspec
import pytest

from app.batch.scenes import scenes_of
from razer.errors import BadInput


def recording(folder: Path) -> Path:
    for name in ("color", "depth"):
        (folder / name).mkdir(parents=True)
    (folder / "intrinsics.json").write_text("{}")
    return folder


def names(text: object) -> list[str]:
    return [scene.name for scene in scenes_of(str(text))]


def test_a_folder_of_recordings_and_what_lies_beside_them(tmp_path):
    for name in ("b", "a", ".hidden"):
        recording(tmp_path / name)
    (tmp_path / "notes").mkdir()
    (tmp_path / "readme.txt").write_text("no list")
    (tmp_path / "scan.sens").write_bytes(b"")
    assert names(tmp_path) == ["a", "b", "scan"]


def test_links_to_nowhere_and_what_cannot_be_read_are_noted_and_left_out(tmp_path, capsys, monkeypatch):
    recording(tmp_path / "a")
    (tmp_path / "gone").symlink_to(tmp_path / "nowhere")
    (tmp_path / "locked").mkdir()
    real = Path.iterdir

    def refusing(path: Path) -> Iterator[Path]:
        if path.name == "locked":  # whatever its mode, root would be let in
            raise PermissionError(13, "Permission denied", str(path))
        return real(path)

    monkeypatch.setattr(Path, "iterdir", refusing)
    assert names(tmp_path) == ["a"]
    assert capsys.readouterr().err.splitlines() == [
        f"note: {tmp_path}/gone leads nowhere: left out",
        f"note: {tmp_path}/locked cannot be read (Permission denied): left out",
    ]


def test_a_recording_is_one_scene_and_a_dataset_has_scenes_in_folders_of_their_own(tmp_path):
    assert names(recording(tmp_path / "alone")) == ["alone"]
    for scene in ("chess", "fire"):
        recording(tmp_path / "set" / scene / "seq-01")
    found = scenes_of(str(tmp_path / "set"))
    assert [scene.name for scene in found] == ["chess_seq-01", "fire_seq-01"]
    assert found[0].recording.path == tmp_path / "set/chess/seq-01"
    for day in ("2024.05.01", "2024.05.02"):
        recording(tmp_path / "days" / day)
    assert names(tmp_path / "days") == ["2024.05.01", "2024.05.02"]
    assert names(tmp_path / "days" / "2024.05.01") == ["2024.05.01"]


def test_a_list_has_paths_beside_it_paths_from_the_root_and_uris(tmp_path):
    recording(tmp_path / "a")
    lines = ["a  # the first", "", "# a remark", "/data/b", f"file://{tmp_path}/c%20d", "memory://bucket/e.sens"]
    (tmp_path / "scenes.txt").write_text("\n".join(lines))
    found = {scene.name: scene.recording.text for scene in scenes_of(str(tmp_path / "scenes.txt"))}
    assert found == {"a": str(tmp_path / "a"), "b": "/data/b", "c d": f"{tmp_path}/c d", "e": "memory://bucket/e.sens"}


def test_a_store_is_searched_by_names():
    store = fsspec.filesystem("memory")
    for name in ("scans/a/color/0.png", "scans/a/depth/0.png", "scans/notes/x.md", "scans/b.sens"):
        store.pipe_file(f"/{name}", b"x")
    assert names("memory://scans") == ["a", "b"]
    assert names("memory://scans/a") == ["a"]
    assert names("memory://scans/b.sens") == ["b"]
    for name in (
        "days/2024.05.01/rgb/0.png",
        "days/2024.05.02/rgb/0.png",
        "days/days/rgb/0.png",
        "days/x.sens/rgb/0.png",
    ):
        store.pipe_file(f"/{name}", b"x")
    assert names("memory://days") == ["2024.05.01", "2024.05.02", "days", "x"]
    store.pipe_file("/scans/list.txt", b"a\nb.sens\n")
    assert [scene.recording.text for scene in scenes_of("memory://scans/list.txt")] == [
        "memory://scans/a",
        "memory://scans/b.sens",
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("nowhere", "does not exist"),
        ("empty", "no recording"),
        ("double.txt", "2 recordings are called a"),
        ("twice.txt", "x/a is listed 2 times"),
        ("reserved.txt", "keeps that name"),
        ("s3://key:secret@bucket/scans", "come from the environment"),
        ("gopher9://host/scans", "no store that fsspec knows"),
        ("", "names no place"),
        ("s3://", "names no bucket"),
        ("s3:///scans", "names no bucket"),
    ],
)
def test_what_cannot_be_is_said(tmp_path, monkeypatch, text, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "double.txt").write_text("x/a\ny/a\n")
    (tmp_path / "twice.txt").write_text("x/a\nb\n./x/a/  # again\n")
    (tmp_path / "reserved.txt").write_text("x/batch_logs\n")
    with pytest.raises(BadInput, match=said) as caught:
        scenes_of(text)
    assert "secret" not in str(caught.value)
