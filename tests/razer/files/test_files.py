"""The door for files: what is hostile is refused in one line, at once, and what is valid comes through."""

from __future__ import annotations

import io
import os
import shutil
import struct
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pytest

from data_tools.registry import open_sequence
from data_tools.truth.open_truth import open_truth
from razer.errors import BadInput, RazerError, UnusableFrame
from razer.files import (
    Archive,
    decode_image,
    image_size,
    plain_os_errors,
    read_bytes,
    read_json,
    read_lines,
    read_npy,
    read_npz,
    read_numbers,
    read_text,
    read_toml,
)
from razer.saved_map import load_map
from razer.vocabulary import vocabulary
from tests.support.recordings import camera_json, write_folder

RUN = Path(__file__).resolve().parents[2] / "fixtures" / "run_format_1"
RNG = np.random.default_rng(0)


def file(folder: Path, data: bytes, name: str = "a") -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


def npy_header(shape: tuple[int, ...], descr: str = "<f8") -> bytes:
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": descr, "fortran_order": False, "shape": shape})
    return head.getvalue()


def refused(read, *arguments, match: str) -> str:
    with pytest.raises(BadInput, match=match) as caught:
        read(*arguments)
    message = str(caught.value)
    assert message.isprintable()
    return message


def test_text_comes_through_with_and_without_a_mark(tmp_path: Path) -> None:
    assert read_text(file(tmp_path, "ä\r\nb".encode("utf-8-sig"))) == "ä\r\nb"
    assert read_lines(file(tmp_path, b"a\nb\n")) == ["a", "b"]
    assert read_numbers(file(tmp_path, b"# x\n1 2 # y\n3e1\n"), "numbers").tolist() == [1, 2, 30]
    assert read_text(file(tmp_path, b"a\xffb"), replace_errors=True) == "a\ufffdb"


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (b"a\nb\n\xff", r"line 3 is no UTF-8 text \(byte 0xff\)"),
        (b"a\n\0", "line 2 has a NUL"),
        (b"x" * 20, "20 bytes where 10"),
    ],
)
def test_what_is_no_text_is_told_with_its_line(tmp_path: Path, data: bytes, match: str) -> None:
    path = file(tmp_path, data)
    message = refused(lambda: read_text(path, max_bytes=10), match=match)
    assert str(path) in message


def test_what_is_no_file_is_refused_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    refused(read_bytes, tmp_path / "pipe", match="is a pipe: give a file")
    refused(read_bytes, tmp_path, match="is a folder")
    refused(read_bytes, Path("/dev/zero"), match="is a device")
    refused(read_bytes, tmp_path / "none", match="No such file")
    refused(read_bytes, tmp_path / "a\0b", match="NUL")
    refused(read_bytes, tmp_path / ("x" * 5000), match="too long")


def test_what_may_not_be_read_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(*_: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("razer.files.file_bytes.os.open", denied)
    refused(read_bytes, file(tmp_path, b"a"), match="cannot be read: Permission denied")


def test_no_descriptor_stays_open_after_a_refusal(tmp_path: Path) -> None:
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(5):
        refused(read_bytes, tmp_path, match="folder")
        refused(read_npy, file(tmp_path, b"x"), match="no array")
        refused(read_npz, file(tmp_path, b"x"), match="no zip archive")
    assert len(os.listdir("/proc/self/fd")) == before


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("[" * 100_000, "lists or sections in one another"),
        ("[" * 100 + "]" * 100, "lists or sections in one another"),
        ("[" + "9" * 5000 + "]", "too large"),
        ("[1e400]", "1e400 is not finite"),
        ("[NaN]", "NaN is not finite"),
        ("[Infinity]", "Infinity is not finite"),
        ('{"a": 1,\n}', "line 2, column 1 is not JSON"),
        (r'["\ud800"]', "half a character"),
    ],
)
def test_hostile_json_is_refused(tmp_path: Path, text: str, match: str) -> None:
    refused(read_json, file(tmp_path, text.encode()), match=match)


def test_valid_json_comes_through(tmp_path: Path) -> None:
    path = file(
        tmp_path,
        b'{"a": [1e99, 100000000000000000000, 0.10000000000000000000000000000000000000000001, "\\ud83d\\ude00"]}',
    )
    assert read_json(path) == {"a": [1e99, 10**20, 0.1, "\U0001f600"]}
    assert np.isnan(read_json(file(tmp_path, b"[NaN]"), only_finite=False)[0])


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("a = " + "[" * 10_000, "in one another"),
        ("a." * 50_000 + "b = 1", "in one another"),
        ("a = " + "9" * 5000, "digits"),
        ("a = " + "9" * 500, "digits"),
        ("a = = 1", "not TOML"),
        ("a = '" + "x" * 2**20 + "'", "bytes where"),
    ],
)
def test_hostile_toml_is_refused(tmp_path: Path, text: str, match: str) -> None:
    refused(read_toml, file(tmp_path, text.encode()), match=match)


def test_valid_toml_comes_through(tmp_path: Path) -> None:
    names = ", ".join(f"'a.b.c {i}'" for i in range(2000))
    assert len(read_toml(file(tmp_path, f"[a.b]\nc = [{names}]\nd = [1.5, 2.5]\n".encode()))["a"]["b"]["c"]) == 2000


def test_arrays_come_through_bit_for_bit(tmp_path: Path) -> None:
    arrays = {
        "plain": RNG.random((3, 4)),
        "fortran": np.asfortranarray(RNG.random((3, 4, 2))),
        "text": np.array("x"),
        "names": np.array(["chair", "é"]),
        "none": np.zeros((0, 4), np.float32),
        "rows": np.zeros(3, [("x", "<f4"), ("n", "u1")]),
        "flags": np.array([True, False]),
    }
    np.savez_compressed(tmp_path / "a.npz", **arrays)
    for name, array in read_npz(tmp_path / "a.npz").items():
        np.testing.assert_array_equal(array, arrays[name], strict=True)
        np.save(tmp_path / "a.npy", arrays[name])
        np.testing.assert_array_equal(read_npy(tmp_path / "a.npy"), arrays[name], strict=True)
    assert list(read_npz(tmp_path / "a.npz", ["flags"])) == ["flags"]
    refused(read_npz, tmp_path / "a.npz", ["other"], match=r"a\.npz has no member other\.npy")


def test_arrays_that_say_too_much_are_refused(tmp_path: Path) -> None:
    huge = npy_header((10**14,))
    refused(read_npy, file(tmp_path, huge), match="is cut short")
    refused(read_npy, file(tmp_path, b""), match="no array of NumPy")
    refused(read_npy, file(tmp_path, npy_header((-1,))), match="is cut short")
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("a.npy", huge)
    refused(read_npz, tmp_path / "a.npz", match=r"member a\.npy is cut short")
    np.save(tmp_path / "o.npy", np.array([{}], object), allow_pickle=True)
    refused(read_npy, tmp_path / "o.npy", match="Python objects")


def test_archives_are_bounded(tmp_path: Path) -> None:
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("zeros", "w") as member:
        for _ in range(300):
            member.write(bytes(2**20))
    refused(Archive, path, match="would become 314,572,800 bytes")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a", b"b" * 1000)
    with Archive(path) as opened:
        assert opened.read("a") == b"b" * 1000
        refused(opened.read, "a", 999, match="member a has 1,000 bytes where 999")
        refused(opened.read, "b", match="no member b")
    data = bytearray(path.read_bytes())
    data[500] ^= 0xFF
    with Archive(file(tmp_path, bytes(data))) as opened:
        refused(opened.read, "a", match="is damaged in its member a")


def encoded(suffix: str, image: np.ndarray) -> bytes:
    return cv2.imencode(suffix, image)[1].tobytes()


def picture() -> np.ndarray:
    return cv2.GaussianBlur(RNG.integers(0, 255, (96, 128, 3), dtype=np.uint8), (9, 9), 0)


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_images_come_through(suffix: str) -> None:
    for image in (picture(), np.full((32, 32, 3), 128, np.uint8), picture()[:1, :1]):
        data = encoded(suffix, image)
        assert image_size(data, "a") == (image.shape[1], image.shape[0])
        expected = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
        np.testing.assert_array_equal(decode_image(data, "a", cv2.IMREAD_COLOR), expected)
        decode_image(data + bytes(100), "a", cv2.IMREAD_COLOR)  # padded, as some cameras do


def test_a_jpeg_that_ends_early_is_refused_though_it_has_an_end_marker() -> None:
    data = encoded(".jpg", picture())
    for share in (0.5, 0.8, 0.95):
        cut = data[: int(share * len(data))] + b"\xff\xd9"
        assert cv2.imdecode(np.frombuffer(cut, np.uint8), cv2.IMREAD_COLOR) is not None  # grey below
        refused(decode_image, cut, "a", cv2.IMREAD_COLOR, match="its data ends before the last pixels")


def test_a_png_that_says_too_much_is_refused_before_it_is_decoded() -> None:
    data = bytearray(encoded(".png", picture()))
    data[16:24] = struct.pack(">II", 40_000, 40_000)
    refused(decode_image, bytes(data), "a", cv2.IMREAD_COLOR, match="40000 x 40000 pixels")
    data[16:24] = struct.pack(">II", 9_000, 9_000)
    refused(decode_image, bytes(data), "a", cv2.IMREAD_COLOR, match="damaged")
    data = bytearray(encoded(".png", picture()))
    data[33:37] = struct.pack(">I", 2**32 - 1)  # bytes of the first chunk of pixels
    refused(decode_image, bytes(data), "a", cv2.IMREAD_COLOR, match="damaged")


def test_every_message_is_one_line_whatever_it_quotes() -> None:
    assert str(RazerError("a\nb\x1b[31m\u2028c")) == "a\\nb\\x1b[31m\\u2028c"
    assert str(RazerError("ä 漢")) == "ä 漢"
    assert len(str(RazerError("x" * 10**6))) < 3000


def test_what_the_system_refuses_names_its_file(tmp_path: Path) -> None:
    def look() -> None:
        with plain_os_errors(tmp_path):
            raise PermissionError(13, "Permission denied", str(tmp_path / "closed"))

    refused(look, match=r"closed cannot be read: Permission denied")


@pytest.mark.parametrize("path", ["a\0b", "x" * 5000, "/dev/zero", "none"])
@pytest.mark.parametrize("door", [load_map, open_sequence, open_truth, vocabulary])
def test_paths_that_are_none_are_one_line(door, path: str) -> None:
    refused(door, path, match=".")


@pytest.mark.parametrize("name", ["instances.json", "mesh.ply", "embeddings.npz"])
@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir])
def test_pipes_and_folders_in_place_of_files_of_a_map_are_one_line(tmp_path: Path, name: str, make) -> None:
    folder = tmp_path / "run"
    shutil.copytree(RUN, folder)
    (folder / name).unlink()
    make(folder / name)
    refused(load_map, folder, match="run")


def test_a_frame_of_a_recording_with_a_hostile_image_is_left_out(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "a", 3, camera_json())
    data = bytearray((folder / "color" / "000001.png").read_bytes())
    data[16:24] = struct.pack(">II", 40_000, 40_000)
    (folder / "color" / "000001.png").write_bytes(data)
    (folder / "depth" / "000002.png").unlink()
    os.mkfifo(folder / "depth" / "000002.png")
    sequence = open_sequence(folder)
    assert sequence[0].depth.any()
    for index, match in ((1, "40000 x 40000"), (2, "is a pipe")):
        with pytest.raises(UnusableFrame, match=match):
            sequence[index]
