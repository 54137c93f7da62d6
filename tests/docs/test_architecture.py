"""The page of the architecture names files that exist, and draws its arrows from lower rooms to higher ones only.

That the arrows are those of the code is held by tests/test_layering.py.
"""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def test_each_row_imports_only_what_stands_above_it():
    (block,) = re.findall(r"<!-- arrows -->\n```text\n(.*?)```", TEXT, re.DOTALL)
    above: set[str] = set()
    for room, targets in (line.split("->") for line in block.splitlines()):
        assert set(targets.split()) <= above, f"{room.strip()} imports what stands below it"
        above.add(room.strip())


def test_files_and_modules_that_are_named_exist():
    for path in set(re.findall(r"`((?:app|razer|slam|data_tools|tests|docs)/[\w./]+)`", TEXT)):
        assert (ROOT / path).exists(), f"docs/architecture.md names {path}"
    for module in set(re.findall(r"`((?:app|razer|slam|data_tools)(?:\.[a-z_]+)+)", TEXT)):
        *package, name = module.split(".")
        folder = ROOT.joinpath(*package)
        offered = folder / "__init__.py"
        homes = (folder / name, folder / f"{name}.py", folder.with_suffix(".py"))
        is_offered = offered.exists() and f'"{name}"' in offered.read_text(encoding="utf-8")
        assert is_offered or any(home.exists() for home in homes), f"there is no {module}"
