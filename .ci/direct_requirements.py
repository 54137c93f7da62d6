"""Print what pyproject.toml asks for directly, one requirement a line: direct_requirements.py REQUIREMENT

REQUIREMENT is '.' or '.[EXTRA,...]'. pip cannot hold a folder against a hash, but it can hold these.
"""

import re
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path


def with_extras(project: dict, extras: Iterable[str]) -> set[str]:
    """The project's requirements and those of extras; extras that name extras of the project itself are followed."""
    found = set(project["dependencies"])
    for extra in extras:
        for requirement in project["optional-dependencies"][extra]:
            own = re.fullmatch(rf"{project['name']}\[(.*)\]", requirement)
            found |= with_extras(project, own[1].split(",")) if own else {requirement}
    return found


if __name__ == "__main__":
    asked = re.fullmatch(r"\.(?:\[(.*)\])?", sys.argv[1])
    project = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]
    print("\n".join(sorted(with_extras(project, (asked[1] or "").replace(" ", "").split(",") if asked[1] else ()))))
