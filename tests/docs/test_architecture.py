"""The table of allowed imports in docs/architecture.md against the imports of the code."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "architecture.md"
# What every part may import: the border, and two modules that know no other part.
EVERYWHERE = {"arrays", "config", "errors", "frame", "geometry", "plugins", "settings", "stages", "vocabulary"}


def allowed() -> dict[str, set[str]]:
    """The table: part of razer -> parts it may import."""
    rows = re.findall(r"^\| `(\w+)` \| ([^|]+) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return {part: set(re.findall(r"`(\w+)`", targets)) for part, targets in rows}


def part_of(module: str) -> str | None:
    """The sub-package or root module of razer that a dotted name lies in."""
    room, _, rest = module.partition(".")
    return rest.split(".")[0] if room == "razer" and rest else None


def imports(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module == "razer":
            yield from (f"razer.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def arrows() -> dict[str, set[str]]:
    """Part of razer -> other parts that its files import."""
    found: dict[str, set[str]] = {}
    for path in sorted((ROOT / "razer").rglob("*.py")):
        relative = path.relative_to(ROOT).with_suffix("")
        part = part_of(".".join(relative.parts))
        if part and part != "__init__":
            targets = {part_of(module) for module in imports(ast.parse(path.read_text(encoding="utf-8")))}
            found.setdefault(part, set()).update(target for target in targets if target and target != part)
    return found


def test_the_table_is_read():
    assert allowed()["tracking"] == {"boxes", "detection", "volume"}
    assert allowed()["boxes"] == set()


def test_every_import_between_parts_is_in_the_table():
    table = allowed()
    for part, targets in arrows().items():
        if part not in EVERYWHERE:
            assert part in table, f"razer.{part} has no row in docs/architecture.md"
            assert targets - EVERYWHERE <= table[part], f"razer.{part} imports {targets - EVERYWHERE - table[part]}"


def test_what_all_may_import_imports_no_part():
    for part, targets in arrows().items():
        if part in EVERYWHERE:
            assert targets <= EVERYWHERE, f"razer.{part} imports {targets - EVERYWHERE}"


def test_the_arrows_go_down_the_table():
    table = allowed()
    order = list(table)
    for part, targets in table.items():
        assert targets <= set(order[: order.index(part)]), f"{part} may import what stands below it"


def test_the_page_names_modules_and_files_that_exist():
    text = PAGE.read_text(encoding="utf-8")
    for path in set(re.findall(r"`((?:app|razer|slam|data_tools|tests|docs)/[\w./]+)`", text)):
        assert (ROOT / path).exists(), f"docs/architecture.md names {path}"
