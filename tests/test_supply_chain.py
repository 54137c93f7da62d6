"""What is installed: versions, hashes, and the list of it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
HASHES = ROOT / ".ci" / "hashes"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PINS = [Requirement(line) for line in (ROOT / "constraints.txt").read_text().splitlines() if line[:1] != "#"]
VERSION_OF = {canonicalize_name(pin.name): str(pin.specifier).removeprefix("==") for pin in PINS}


def hashed(name: str) -> dict[str, tuple[str, list[str]]]:
    """(version, hashes) of each package in one of the files, as pip reads it."""
    packages = {}
    for line in (HASHES / name).read_text().replace("\\\n", " ").splitlines():
        requirement, *hashes = re.split(r"\s+--hash=sha256:", line.strip())
        package = Requirement(requirement)
        packages[canonicalize_name(package.name)] = (str(package.specifier).removeprefix("=="), hashes)
    return packages


def requirements() -> list[Requirement]:
    """All that pyproject.toml asks for directly, of every extra."""
    extras = PROJECT["optional-dependencies"].values()
    found = map(Requirement, [*PROJECT["dependencies"], *(each for extra in extras for each in extra)])
    return [each for each in found if each.name != PROJECT["name"]]


def test_every_tested_version_has_its_hashes() -> None:
    packages = hashed("packages.txt") | hashed("installer.txt")
    assert {name: packages[name][0] for name in VERSION_OF} == VERSION_OF
    for name, (_, hashes) in packages.items():
        assert hashes, name
        assert all(re.fullmatch(r"[0-9a-f]{64}", each) for each in hashes), name


def test_a_cpu_build_of_the_tested_torch_has_its_hash() -> None:
    ((name, (cpu, hashes)),) = hashed("cpu_torch.txt").items()
    assert (name, cpu) == ("torch", f"{VERSION_OF['torch']}+cpu")
    assert hashes
    assert not set(hashes) & set(hashed("packages.txt")["torch"][1])


def test_what_is_tested_lies_between_what_is_allowed() -> None:
    for each in requirements():
        if (tested := VERSION_OF.get(canonicalize_name(each.name))) is not None:
            assert each.specifier.contains(tested), each
    untested = {each.name for each in requirements() if canonicalize_name(each.name) not in VERSION_OF}
    assert untested == {"open_clip_torch"}  # it brings torchvision, which must match the build of torch


@pytest.mark.parametrize(
    ("asked", "extras"), [(".", ()), (".[serve]", ("serve",)), (".[dev]", ("dev", "ros", "serve"))]
)
def test_what_is_installed_by_hash_is_what_the_project_asks_for(asked: str, extras: tuple[str, ...]) -> None:
    command = [sys.executable, ROOT / ".ci" / "direct_requirements.py", asked]
    printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    expected = set(PROJECT["dependencies"])
    for extra in extras:
        expected |= {each for each in PROJECT["optional-dependencies"][extra] if not each.startswith("razer[")}
    assert expected <= set(printed)
    assert not any(line.startswith("razer") for line in printed)
    assert ("pytest>=9" in printed) == ("dev" in asked)


def test_nothing_names_where_it_was_fetched() -> None:
    for file in HASHES.iterdir():
        assert not re.search(r"://|/opt/|/tmp/|--index|--find-links", file.read_text()), file


@pytest.mark.full
def test_the_bill_of_materials_names_what_is_installed(tmp_path: Path) -> None:
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    out = tmp_path / "sbom.json"
    subprocess.run([ROOT / ".ci" / "sbom", sys.executable, out], check=True, timeout=300)
    text = out.read_text()
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None
    bill = json.loads(text)
    assert (bill["bomFormat"], bill["metadata"]["component"]["name"]) == ("CycloneDX", "razer")
    listed = {canonicalize_name(each["name"]): each for each in bill["components"]}
    root = bill["metadata"]["component"]["bom-ref"]
    needed = next(each["dependsOn"] for each in bill["dependencies"] if each["ref"] == root)
    for requirement in map(Requirement, PROJECT["dependencies"]):
        component = listed[canonicalize_name(requirement.name)]
        assert component["version"] == version(requirement.name)
        assert component["purl"].startswith(f"pkg:pypi/{canonicalize_name(requirement.name)}@")
        assert component["bom-ref"] in needed
    assert str(ROOT) not in text
