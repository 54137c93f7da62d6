"""The viewer that is shipped is the one that its sources give."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path

import pytest

VIEWER = Path(str(files("app.page"))) / "viewer"
BUNDLE = VIEWER.parent / "bundle"


def test_the_bundle_is_one_plain_script_with_its_licences():
    script = (BUNDLE / "viewer.js").read_text()
    assert "</script" not in script
    assert "<!--" not in script
    assert script.startswith(('"use strict";(()=>{', "(()=>{"))
    licences = (BUNDLE / "THIRD_PARTY_LICENSES.txt").read_text()
    wanted = json.loads((VIEWER / "package.json").read_text())["dependencies"]
    for name, version in wanted.items():
        assert f"{name} {version} (MIT)" in licences
    assert "Permission is hereby granted" in licences


def test_packages_are_pinned_and_no_host_is_named():
    package = json.loads((VIEWER / "package.json").read_text())
    versions = {**package["dependencies"], **package["devDependencies"]}
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", version) for version in versions.values())
    lock = (VIEWER / "package-lock.json").read_text()
    assert '"resolved"' not in lock
    entries = json.loads(lock)["packages"]
    assert all(entries[f"node_modules/{name}"]["version"] == version for name, version in versions.items())


@pytest.mark.full
def test_the_sources_build_the_same_bytes(tmp_path):
    if shutil.which("npm") is None:
        pytest.skip("there is no node on this machine")
    copy = tmp_path / "viewer"
    shutil.copytree(VIEWER, copy, ignore=shutil.ignore_patterns("node_modules"))
    ready = subprocess.run(["npm", "ci", "--no-audit", "--no-fund"], cwd=copy, capture_output=True, text=True)
    if ready.returncode:
        pytest.skip(f"npm cannot fetch the packages here: {ready.stderr.strip()[-200:]}")
    for command in (["npm", "run", "check"], ["npm", "test"], ["node", "build.mjs", str(tmp_path / "built")]):
        done = subprocess.run(command, cwd=copy, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    for path in BUNDLE.iterdir():
        assert (tmp_path / "built" / path.name).read_bytes() == path.read_bytes(), path.name
