"""The wheel: built, installed outside the repository, and tried there."""

from __future__ import annotations

import os
import site
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("app", "data_tools", "razer", "slam")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The project's wheel, built from a copy of what git tracks, so that nothing is left in the repository."""
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", *PACKAGES, "pyproject.toml", "README.md"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    if listed.returncode:
        pytest.skip("the tests do not lie in a git checkout")
    for name in listed.stdout.split():
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    options = ["--no-deps", "--no-build-isolation", "--quiet", "--disable-pip-version-check"]
    subprocess.run([sys.executable, "-m", "pip", "wheel", *options, "-w", out, source], check=True)
    return next(out.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """A python that has the wheel, and sees the libraries of this environment but not this repository."""
    home = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", home], check=True)
    python = home / "bin" / "python"
    where = [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    own = Path(subprocess.run(where, capture_output=True, text=True, check=True).stdout.strip())
    # A path in a .pth is added as it is: what is editable in this environment stays unseen.
    (own / "libraries.pth").write_text("\n".join({sysconfig.get_path("purelib"), *site.getsitepackages()}))
    options = ["--no-deps", "--no-index", "--quiet", "--disable-pip-version-check"]
    subprocess.run([sys.executable, "-m", "pip", "--python", python, "install", *options, wheel], check=True)
    return python


def call(python, *arguments, cwd):
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    command = [str(part) for part in (python, *arguments)]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)


def test_it_holds_the_packages_with_their_data_and_nothing_else(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == set(PACKAGES)
    for package in PACKAGES:
        assert f"{package}/py.typed" in names
    assert "razer/models/hub/catalogue.toml" in names
    assert {f"razer/vocabularies/{name}.csv" for name in ("coco", "lvis", "scannet200")} <= set(names)
    assert "razer/vocabularies/kinds.toml" in names


def test_every_package_of_the_repository_is_in_it(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    ours = {p.relative_to(ROOT).as_posix() for package in PACKAGES for p in (ROOT / package).rglob("*.py")}
    assert ours <= names


@pytest.mark.full
def test_it_works_outside_the_repository(installed, tmp_path):
    where = "import app, data_tools, razer, slam; print(*(m.__file__ for m in (app, data_tools, razer, slam)))"
    places = call(installed, "-c", where, cwd=tmp_path)
    assert places.returncode == 0, places.stderr
    assert str(ROOT) not in places.stdout
    razer = installed.parent / "razer"
    assert call(razer, "--help", cwd=tmp_path).returncode == 0
    demo = call(razer, "demo", "--frames", 10, "-o", tmp_path / "run", cwd=tmp_path)
    assert demo.returncode == 0, demo.stderr
    answer = call(razer, "query", tmp_path / "run", "a chair", cwd=tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert "chair" in answer.stdout
