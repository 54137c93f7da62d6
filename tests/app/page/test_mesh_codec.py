"""The mesh of the page against a literal reader of its sections, written from the description alone."""

from __future__ import annotations

import numpy as np
import pytest

from app.page.mesh_codec import QUANTUM_M, encode_mesh
from app.page.packet import pack, unpack
from razer.mesh.labelled_mesh import LabelledMesh
from tests.support.page_maps import room_mesh


def numbers(section: bytes, count: int) -> list[int]:
    """Byte planes, low bytes first."""
    planes = len(section) // count if count else 0
    return [sum(section[plane * count + i] << (8 * plane) for plane in range(planes)) for i in range(count)]


def signed(number: int) -> int:
    return number // 2 if number % 2 == 0 else -(number + 1) // 2


def bits(section: bytes, count: int) -> list[bool]:
    return [bool(section[i // 8] >> (i % 8) & 1) for i in range(count)]


def read_triangles(header, sections):
    """Triangles, and of each vertex whom it is guessed from."""
    triangles, guesses, old, corner, hung, parent = [], [], 0, 0, 0, 0
    edges = list(sections["edge"])
    is_new = bits(sections["is_new"], 8 * len(sections["is_new"]))
    back = numbers(sections["back"], len(sections["back"]) // 3)
    steps = numbers(sections["parent_step"], len(edges) - edges.count(3))

    def next_vertex(guess):
        nonlocal corner, old
        corner += 1
        if is_new[corner - 1]:
            guesses.append(guess)
            return len(guesses) - 1
        old += 1
        return len(guesses) - back[old - 1]

    for edge in edges:
        if edge == 3:
            triangles.append([next_vertex((len(guesses) - 1,) * 3) for _ in range(3)])
            continue
        parent += steps[hung]
        hung += 1
        start, end = triangles[parent][(edge + 1) % 3], triangles[parent][edge]
        triangles.append([start, end, next_vertex((start, end, triangles[parent][(edge + 2) % 3]))])
    return triangles, guesses


def read_mesh(header, sections):
    triangles, guesses = read_triangles(header, sections)
    n = header["vertices"]
    lattice = np.zeros((n, 3), int)
    for axis, name in enumerate("xyz"):
        for v, number in enumerate(numbers(sections[f"position_{name}"], n)):
            a, b, c = guesses[v]
            guess = 0 if a < 0 else lattice[a, axis] + lattice[b, axis] - lattice[c, axis]
            lattice[v, axis] = guess + signed(number)

    def from_mean(name):
        values = []
        for v, number in enumerate(numbers(sections[name], n)):
            a, b, _ = guesses[v]
            values.append(signed(number) + (0 if a < 0 else (values[a] + values[b]) >> 1))
        return np.array(values)

    green = from_mean("color_green")
    colors = np.stack([from_mean("color_red") + green, green, from_mean("color_blue") + green], axis=1)
    written = iter(numbers(sections["instance"], len(sections["instance"]) // 2))
    slots = []
    for v, differs in enumerate(bits(sections["instance_differs"], n)):
        slots.append(next(written) if differs else slots[guesses[v][1]] if guesses[v][1] >= 0 else 0)
    positions = np.array(header["origin_m"]) + header["quantum_m"] * lattice
    return positions, colors, np.array(header["ids"])[slots], np.array(triangles), from_mean("occlusion")


def as_set(positions, triangles, *columns):
    """Triangles by the values of their corners, from whichever corner they begin; positions to a tenth of a voxel."""
    rows = [np.rint(positions * 100).astype(int), *columns]
    corners = [[tuple(np.concatenate([np.atleast_1d(c[v]) for c in rows]).tolist()) for v in t] for t in triangles]
    return sorted(min(tuple(c[i:] + c[:i]) for i in range(3)) for c in corners)


@pytest.fixture(scope="module")
def mesh():
    return room_mesh()


def test_a_literal_reader_finds_the_same_triangles_places_colours_and_instances(mesh):
    occlusion = (np.arange(len(mesh.vertices)) % 256).astype(np.uint8)
    encoded = encode_mesh(mesh, occlusion)
    header, sections = unpack(pack(encoded.header, encoded.sections))
    positions, colors, instances, triangles, openness = read_mesh(header, sections)
    found = as_set(positions, triangles, colors, instances, openness)
    expected = as_set(mesh.vertices, mesh.triangles, mesh.colors >> 1, mesh.instances, occlusion >> 3)
    assert found == expected


def test_places_are_within_half_the_lattice(mesh):
    shifted = LabelledMesh(mesh.vertices * 1.23457 - 7.7, mesh.colors, mesh.instances, mesh.triangles)
    encoded = encode_mesh(shifted)
    positions, *_ = read_mesh(encoded.header, encoded.sections)
    nearest = np.abs(positions[:, None] - shifted.vertices[None]).max(axis=2).min(axis=1)
    assert nearest.max() <= QUANTUM_M / 2 + 1e-6


@pytest.mark.parametrize(
    "triangles",
    [
        [[0, 1, 2], [1, 0, 3], [0, 1, 4]],  # three on one edge, two of them in the same direction
        [[0, 1, 2], [0, 1, 2]],  # the same twice
        [[0, 1, 2], [0, 2, 1]],  # both sides
        [[0, 1, 2], [2, 3, 4]],  # a corner alone
        [[0, 1, 2], [1, 0, 3], [1, 3, 4]],
        [[0, 1, 2], [5, 6, 7], [2, 1, 5]],
    ],
)
def test_surfaces_that_are_no_manifolds_come_back(triangles):
    random = np.random.default_rng(1)
    vertices = random.uniform(0, 2, (8, 3)).astype(np.float32)
    mesh = LabelledMesh(vertices, random.integers(0, 256, (8, 3), np.uint8), np.arange(8, dtype=np.int32) % 3,
                        np.array(triangles, np.int32))  # fmt: skip
    encoded = encode_mesh(mesh)
    positions, colors, instances, found, _ = read_mesh(encoded.header, encoded.sections)
    expected = as_set(vertices, triangles, mesh.colors >> 1, mesh.instances)
    assert as_set(positions, found, colors, instances) == expected


def test_an_empty_mesh_is_empty():
    empty = LabelledMesh(*(np.zeros(shape, kind) for shape, kind in
                           (((0, 3), "f4"), ((0, 3), "u1"), (0, "i4"), ((0, 3), "i4"))))  # fmt: skip
    encoded = encode_mesh(empty)
    assert (encoded.header["vertices"], encoded.header["triangles"]) == (0, 0)
    assert not any(encoded.sections.values())


def test_what_is_no_packet_is_refused():
    packed = pack({"a": 1}, {"b": b"xyz"})
    assert unpack(packed) == ({"a": 1}, {"b": b"xyz"})
    import gzip

    with pytest.raises(ValueError, match="no page data"):
        unpack(gzip.compress(b"something else"))
