"""`import data_tools`: what it offers, what it costs, and sequences that iterate."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from rich.console import Console

import data_tools
from app.frames.selection import Selection
from data_tools import open_sequence, write_recording
from data_tools.recordings.camera import Declared
from data_tools.recordings.sequence import FrameIteration, RgbdSequence
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics
from tests.support.recordings import camera_json, write_folder


def test_names_of_the_face():
    assert data_tools.__all__ == ["open_sequence", "write_recording"]
    assert set(data_tools.__all__) <= set(dir(data_tools))
    with pytest.raises(AttributeError, match="nothing_of_the_sort"):
        data_tools.nothing_of_the_sort  # noqa: B018


def test_names_are_functions_whatever_was_imported_before():
    code = (
        "import data_tools.registry, data_tools.writers.table\n"
        "from data_tools import open_sequence, write_recording\n"
        "assert callable(open_sequence) and callable(write_recording)\n"
        "assert data_tools.open_sequence is data_tools.registry.open_sequence\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_import_alone_loads_no_numpy():
    code = "import data_tools, sys; assert not {'numpy', 'scipy', 'cv2'} & sys.modules.keys(); dir(data_tools)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_recording_of_files_iterates_over_its_usable_frames(tmp_path):
    write_folder(tmp_path, frames=3, camera=camera_json())
    (tmp_path / "depth" / "000001.png").write_bytes(b"")
    sequence = open_sequence(str(tmp_path))
    with pytest.warns(UserWarning, match="frame 1 is skipped: depth/000001.png is empty") as caught:
        assert [frame.index for frame in sequence] == [0, 2]
    assert len(caught) == 1
    assert caught[0].filename == __file__  # the warning points at the loop
    assert len(sequence) == 3
    with pytest.raises(UnusableFrame):
        sequence[1]


@pytest.mark.filterwarnings("error")
def test_rendered_sequences_and_selections_iterate():
    room = SyntheticRoom(0, 5, 40, 30)
    assert [frame.index for frame in room] == [0, 1, 2, 3, 4]
    part = Selection.of(room, range(0, len(room), 2), Console(quiet=True))
    assert [frame.index for frame in part] == [0, 2, 4]


@dataclass(frozen=True)
class OneFrame(FrameIteration):
    """The smallest sequence of one's own."""

    name: str
    declared: Declared
    has_poses: bool
    depth_scale: float = 1.0

    @property
    def intrinsics(self) -> Intrinsics:
        assert self.declared.depth_camera is not None
        return self.declared.depth_camera.at((40, 30))

    def __len__(self) -> int:
        return 1

    def __getitem__(self, index: int) -> Frame:
        return SyntheticRoom(0, 1, 40, 30)[index]


def read_one_frame(folder: Path, declared: Declared, use_poses: bool) -> RgbdSequence:
    return OneFrame(folder.name, declared, use_poses)


def test_a_reader_of_ones_own_is_given_as_a_function(tmp_path):
    sequence = open_sequence(tmp_path, reader=read_one_frame, camera="30,30,19.5,14.5", use_poses=False)
    assert (sequence.name, sequence.has_poses) == (tmp_path.name, False)
    assert sequence.intrinsics == Intrinsics(40, 30, 30, 30, 19.5, 14.5)
    assert [frame.index for frame in sequence] == [0]


def test_a_reader_named_by_text_needs_trust(tmp_path):
    with pytest.raises(BadInput, match="code from outside"):
        open_sequence(tmp_path, reader=f"{__name__}:read_one_frame")
    with pytest.raises(BadInput, match="does not exist"):
        open_sequence(tmp_path / "nowhere", reader=read_one_frame)


def test_what_is_written_is_read_again(tmp_path):
    room = SyntheticRoom(0, 2, 40, 30)
    assert write_recording(room, str(tmp_path / "own"), lossless=True) == []
    assert len(list(open_sequence(tmp_path / "own"))) == 2
    assert write_recording(room, tmp_path / "tum", "tum") == []
    assert (tmp_path / "tum" / "groundtruth.txt").is_file()
