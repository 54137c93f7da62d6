"""One door for files from outside: bounded reading of text, JSON, TOML, NumPy arrays, archives and images.

Each failure is a `BadInput` of one line that names the file, the place in it where that is known, and the fix.
"""

from razer.files.archives import Archive, MissingMember
from razer.files.arrays import read_npy, read_npz
from razer.files.file_bytes import MAX_BYTES, MissingFile, beginning, opened, plain_os_errors, read_bytes
from razer.files.images import decode_image, image_size
from razer.files.text import (
    MALFORMED,
    MAX_TEXT_BYTES,
    parse_json,
    parse_toml,
    read_json,
    read_lines,
    read_numbers,
    read_text,
    read_toml,
)

__all__ = [
    "MALFORMED",
    "MAX_BYTES",
    "MAX_TEXT_BYTES",
    "Archive",
    "MissingFile",
    "MissingMember",
    "beginning",
    "decode_image",
    "image_size",
    "opened",
    "parse_json",
    "parse_toml",
    "plain_os_errors",
    "read_bytes",
    "read_json",
    "read_lines",
    "read_npy",
    "read_npz",
    "read_numbers",
    "read_text",
    "read_toml",
]
