"""The GLB of a map passes the Khronos validator."""

from __future__ import annotations

import json
import shutil
import subprocess

import pytest

from app.render.glb import NodeFacts, write_glb
from razer.mesh.labelled_mesh import LabelledMesh
from tests.support.surfaces import box, joined, plate

PACKAGE = "gltf-validator@2.0.0-dev.3.10"
SCRIPT = """
const validator = require("gltf-validator"), fs = require("fs");
const bytes = new Uint8Array(fs.readFileSync(process.argv[1]));
validator.validateBytes(bytes).then((report) => console.log(JSON.stringify(report)));
"""


@pytest.fixture(scope="module")
def validate(tmp_path_factory):
    """Issues that the validator has with a file."""
    if shutil.which("npm") is None:
        pytest.skip("there is no node on this machine")
    folder = tmp_path_factory.mktemp("validator")
    (folder / "package.json").write_text("{}")
    command = ["npm", "install", "--no-audit", "--no-fund", PACKAGE]
    ready = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if ready.returncode:
        pytest.skip(f"npm cannot fetch {PACKAGE} here: {ready.stderr.strip()[-200:]}")

    def issues(path):
        done = subprocess.run(["node", "-e", SCRIPT, str(path)], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)["issues"]

    return issues


@pytest.mark.full
def test_a_map_is_valid_without_a_warning(tmp_path, validate):
    mesh = joined(
        box((0, 0, 0), (4, 3, 2.5), 1, outwards=False),
        box((1, 1, 0), (2, 2, 1), 7),
        plate((0, 0, 1), (1, 0, 0), (0, 1, 0), 0),
    )
    write_glb(tmp_path / "mesh.glb", mesh, facts={1: NodeFacts("wall", 0.5), 7: NodeFacts("tisch ö", None)})
    assert validate(tmp_path / "mesh.glb")["messages"] == []


@pytest.mark.full
def test_an_empty_map_is_valid_and_a_broken_file_is_not(tmp_path, validate):
    write_glb(tmp_path / "mesh.glb", LabelledMesh.empty())
    assert validate(tmp_path / "mesh.glb")["numErrors"] == 0
    write_glb(tmp_path / "mesh.glb", box((0, 0, 0), (1, 1, 1), 1))
    data = (tmp_path / "mesh.glb").read_bytes()
    (tmp_path / "mesh.glb").write_bytes(data.replace(b'"SCALAR"', b'"SCALER"'))
    assert validate(tmp_path / "mesh.glb")["numErrors"] > 0
