"""Reader of PLY files, ASCII and binary: properties of vertices, and triangles with the properties of their faces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from data_tools.recordings.local_origin import HERE, local_origin
from razer.arrays import Float64Array, FloatArray, Int32Array
from razer.errors import BadInput
from razer.files import MALFORMED, read_bytes

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": "="}
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True, slots=True)
class Ply:
    """vertices: a column (V,) for each property; triangles (T, 3) int32; of_face: a column (T,) for each property of
    faces that is no list. A face with more corners has become several triangles round its first corner; faces (T,)
    int32 counts which face a triangle is of."""

    vertices: Mapping[str, NDArray]
    triangles: Int32Array
    of_face: Mapping[str, NDArray]
    faces: Int32Array

    def points(self, path: Path) -> FloatArray:
        """x, y, z of the vertices, (V, 3) float32, or float64 as they are where they lie too far from zero for that;
        raises BadInput naming `path` where they are missing."""
        points = np.stack([self.column(name, path) for name in "xyz"], axis=1)
        is_far = points.dtype == np.float64 and local_origin(points) != HERE
        return points if is_far else points.astype(np.float32)

    def column(self, name: str, path: Path) -> NDArray:
        """One property of the vertices; raises BadInput naming `path` where it is missing."""
        if name not in self.vertices:
            raise BadInput(f"{path} has no vertex property {name}: it has {', '.join(self.vertices)}")
        return self.vertices[name]


@dataclass(frozen=True, slots=True)
class _Element:
    """A part of the file: properties are (name, type) or, for a list, (name, type of count, type)."""

    name: str
    count: int
    properties: tuple[tuple[str, ...], ...]


def read_ply(path: Path) -> Ply:
    """A mesh or a cloud, ascii or binary; raises BadInput naming the file if it is none or is cut short."""
    data = read_bytes(path)
    try:
        order, elements, start = _header(data)
        with np.errstate(over="ignore", invalid="ignore"):  # numbers that no vertex has are found below
            tables = (_ascii if order == "=" else _binary)(data, start, elements, order)
    except (*MALFORMED, MemoryError) as error:
        raise BadInput(f"{path} is no PLY file, or is cut short (problem: {error})") from None
    corners, faces, of_face = _triangles(tables.get("face", {}))
    vertices = tables.get("vertex", {})
    if len(corners) and (corners.min() < 0 or corners.max() >= len(next(iter(vertices.values()), ()))):
        raise BadInput(f"{path} has faces with corners that are no vertices of it")
    return Ply(vertices, corners, of_face, faces)


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise ValueError("no header")
    start = data.index(b"\n", end) + 1
    order, elements = "", list[_Element]()
    for words in (line.split() for line in data[:end].decode("ascii", "replace").splitlines()):
        if words[:1] == ["format"]:
            order = _ORDERS[words[1]]
        elif words[:1] == ["element"]:
            elements.append(_Element(words[1], int(words[2]), ()))
        elif words[:1] == ["property"]:
            kinds = tuple(_TYPES[word] for word in words[1:-1] if word != "list")
            last = elements.pop()
            elements.append(_Element(last.name, last.count, (*last.properties, (words[-1], *kinds))))
    return order, elements, start


def _binary(data: bytes, start: int, elements: list[_Element], order: str) -> dict[str, dict[str, NDArray]]:
    tables = {}
    for element in elements:
        tables[element.name], start = _binary_table(data, start, element, order)
    return tables


def _binary_table(data: bytes, start: int, element: _Element, order: str) -> tuple[dict[str, NDArray], int]:
    """The columns of one element and where the next begins. Lists are read as all of one length first, as those of
    a triangle mesh are; where they are not, row by row."""
    lengths = {name: _first_length(data, start, element, order) for name, *kinds in element.properties if kinds[1:]}
    row = _row_dtype(element, lengths, order)
    if len(data) >= start + element.count * row.itemsize:
        table = np.frombuffer(data, row, element.count, start)
        if all((table[f"count of {name}"] == length).all() for name, length in lengths.items()):
            return {name: table[name] for name, *_ in element.properties}, start + table.nbytes
    if not lengths:
        raise ValueError(f"{element.count} of {element.name} expected")
    return _ragged_table(data, start, element, order)


def _row_dtype(element: _Element, lengths: Mapping[str, int], order: str) -> np.dtype[np.void]:
    """A row of an element whose lists are of these lengths."""
    fields: list[tuple] = []
    for name, *kinds in element.properties:
        if len(kinds) == 1:
            fields.append((name, order + kinds[0]))
        else:
            fields += [(f"count of {name}", order + kinds[0]), (name, order + kinds[1], (lengths[name],))]
    return np.dtype(fields)


def _first_length(data: bytes, start: int, element: _Element, order: str) -> int:
    """How long the only list of the first row is (0 where there is no row, or more than one list)."""
    lists = [i for i, (_, *kinds) in enumerate(element.properties) if len(kinds) > 1]
    if not element.count or len(lists) > 1:
        return 0
    before = sum(np.dtype(kinds[0]).itemsize for _, *kinds in element.properties[: lists[0]])
    return int(np.frombuffer(data, order + element.properties[lists[0]][1], 1, start + before)[0])


def _ragged_table(data: bytes, start: int, element: _Element, order: str) -> tuple[dict[str, NDArray], int]:
    columns: dict[str, list] = {name: [] for name, *_ in element.properties}
    for _ in range(element.count):
        for name, *kinds in element.properties:
            count = 1
            if len(kinds) > 1:
                count = int(np.frombuffer(data, order + kinds[0], 1, start)[0])
                start += np.dtype(kinds[0]).itemsize
            values = np.frombuffer(data, order + kinds[-1], count, start)
            columns[name].append(values if len(kinds) > 1 else values[0])
            start += values.nbytes
    return {name: _column(values) for name, values in columns.items()}, start


def _ascii(data: bytes, start: int, elements: list[_Element], _order: str) -> dict[str, dict[str, NDArray]]:
    numbers = np.array(data[start:].split(), dtype=np.float64)
    tables = {}
    for element in elements:
        tables[element.name], used = _ascii_table(numbers, element)
        numbers = numbers[used:]
    return tables


def _ascii_table(numbers: Float64Array, element: _Element) -> tuple[dict[str, NDArray], int]:
    """The columns of one element and how many numbers they take; lists as in a binary file."""
    widths = [1] * len(element.properties)
    lists = [i for i, (_, *kinds) in enumerate(element.properties) if len(kinds) > 1]
    if len(lists) == 1 and element.count:
        widths[lists[0]] += int(numbers[lists[0]])
    ends = np.cumsum(widths)
    used = int(ends[-1]) * element.count if widths else 0
    if len(lists) <= 1 and used <= len(numbers):
        rows = numbers[:used].reshape(element.count, int(ends[-1]))
        if all((rows[:, i] == widths[i] - 1).all() for i in lists):
            columns = {}
            for (name, *kinds), end, width in zip(element.properties, ends, widths, strict=True):
                values = rows[:, end - 1] if len(kinds) == 1 else rows[:, end - width + 1 : end]
                columns[name] = values.astype(kinds[-1])
            return columns, used
    if not lists:
        raise ValueError(f"{element.count} of {element.name} expected")
    return _ragged_ascii(numbers, element)


def _ragged_ascii(numbers: Float64Array, element: _Element) -> tuple[dict[str, NDArray], int]:
    columns: dict[str, list] = {name: [] for name, *_ in element.properties}
    at = 0
    for _ in range(element.count):
        for name, *kinds in element.properties:
            count = int(numbers[at]) if len(kinds) > 1 else 1
            at += len(kinds) > 1
            if at + count > len(numbers):
                raise ValueError(f"{element.count} of {element.name} expected")
            values = numbers[at : at + count].astype(kinds[-1])
            columns[name].append(values if len(kinds) > 1 else values[0])
            at += count
    return {name: _column(values) for name, values in columns.items()}, at


def _column(values: list) -> NDArray:
    """An array of numbers, or of arrays where lists have different lengths."""
    if values and isinstance(values[0], np.ndarray) and len({len(value) for value in values}) > 1:
        column = np.empty(len(values), object)
        column[:] = values
        return column
    return np.array(values)


def _triangles(face: Mapping[str, NDArray]) -> tuple[Int32Array, Int32Array, dict[str, NDArray]]:
    """Triangles as fans over the corners of each face, which face each is of, and that face's properties."""
    corners = next((face[name] for name in _CORNERS if name in face), np.zeros((0, 3), np.int32))
    if corners.dtype != object:
        fans = max(corners.shape[1] - 2, 0) if corners.ndim == 2 else 0
        parts = [corners[:, [0, i + 1, i + 2]] for i in range(fans)]
        triangles = np.stack(parts, axis=1).reshape(-1, 3) if parts else np.zeros((0, 3))
        of_triangle = np.repeat(np.arange(len(corners), dtype=np.int32), fans)
    else:
        fans_of = [max(len(each) - 2, 0) for each in corners]
        triangles = np.array([[c[0], c[i + 1], c[i + 2]] for c in corners for i in range(len(c) - 2)]).reshape(-1, 3)
        of_triangle = np.repeat(np.arange(len(corners), dtype=np.int32), fans_of)
    rest = {name: column for name, column in face.items() if name not in _CORNERS and column.ndim == 1}
    return triangles.astype(np.int32), of_triangle, {name: column[of_triangle] for name, column in rest.items()}
