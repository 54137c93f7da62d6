"""The picture of the house, enforced: who imports whom, and what is fenced."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("app", "razer", "slam", "data_tools")
FILES = sorted(path for room in ROOMS for path in (ROOT / room).rglob("*.py"))
BORDER = {
    "razer.arrays",
    "razer.errors",
    "razer.files",
    "razer.frame",
    "razer.geometry",
    "razer.plugins",
    "razer.settings",
    "razer.vocabulary",
}
ONE_FILE_FENCES = ("gtsam", "rtree", "rosbags", "ray", "lancedb")
MODEL_LIBRARIES = {
    "onnxruntime",
    "huggingface_hub",
    "ultralytics",
    "transformers",
    "open_clip",
    "clip",
    "torchvision",
    "timm",
}
SERVE_LIBRARIES = {"fastapi", "starlette", "uvicorn", "mcp", "mcp_types"}
SERVING_ROOMS = ("app/server/", "app/agents/")
# Attributes leave the device where a surface is extracted and where a map is saved, nowhere else.
MAY_COPY_TO_HOST = {"razer/volume/mesh_extraction.py", "razer/storage/volume_npz.py"}
ATTRIBUTE_READERS = {"attribute", "read", "blocks", "views", "labels_at", "histograms_at"}


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


OURS = {module_name(path) for path in FILES}


def imported(tree: ast.AST, package: str = "") -> Iterator[str]:
    """Every module named by an import anywhere in the file, whether at the top or inside a function."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            anchor = package.rsplit(".", node.level - 1)[0] if node.level > 1 else package
            base = ".".join(filter(None, [anchor if node.level else "", node.module]))
            submodules = [f"{base}.{alias.name}" for alias in node.names if f"{base}.{alias.name}" in OURS]
            yield from submodules or [base]


@cache
def imports_of(path: Path) -> frozenset[str]:
    package = module_name(path) if path.name == "__init__.py" else module_name(path).rpartition(".")[0]
    return frozenset(imported(tree_of(path), package))


def named_imports_by_string() -> Iterator[tuple[str, str]]:
    """Modules that a plug-in table names as "module:Class"."""
    for path in FILES:
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                match = re.fullmatch(r"((?:app|razer|slam|data_tools)[\w.]*):\w+", node.value)
                if match:
                    yield relative(path), match[1]


def direction_error(room: str, module: str) -> bool:
    """Whether a file in `room` must not import `module`."""
    other = module.split(".")[0]
    if other not in (*ROOMS, "tests") or other == room or room == "app":
        return other == "tests"
    return room == "razer" or module not in BORDER


def test_rule_of_direction_on_known_cases():
    assert direction_error("razer", "slam.system")
    assert direction_error("razer", "app.cli")
    assert direction_error("slam", "data_tools.registry")
    assert direction_error("data_tools", "razer.volume.voxel_map")
    assert direction_error("slam", "razer")
    assert direction_error("app", "tests.test_cli")
    assert not direction_error("slam", "razer.frame")
    assert not direction_error("data_tools", "razer.plugins")
    assert not direction_error("app", "razer.mapper")
    assert not direction_error("razer", "numpy")


def test_import_parser_on_known_cases():
    source = "import a.b, c\nfrom d import e\nfrom razer import frame\ndef f():\n    from .sibling import x\n"
    assert set(imported(ast.parse(source), "razer")) == {"a.b", "c", "d", "razer.frame", "razer.sibling"}


@pytest.mark.parametrize("path", FILES, ids=relative)
def test_imports_follow_the_direction(path):
    room = path.relative_to(ROOT).parts[0]
    assert [module for module in imports_of(path) if direction_error(room, module)] == []


def test_named_parts_follow_the_direction_and_exist():
    for file, module in named_imports_by_string():
        assert module in OURS, f"{file} names {module}, which does not exist"
        assert not direction_error(file.split("/")[0], module), f"{file} names {module}"


@pytest.mark.parametrize("library", ONE_FILE_FENCES)
def test_fenced_library_is_imported_by_one_file_at_most(library):
    users = [relative(path) for path in FILES if library in {name.split(".")[0] for name in imports_of(path)}]
    assert len(users) <= 1, users


def test_rerun_stays_in_recordings():
    for path in FILES:
        if "rerun" in {name.split(".")[0] for name in imports_of(path)}:
            assert relative(path).startswith("app/timeline/recording/")


def test_model_libraries_stay_in_models():
    for path in FILES:
        found = {name.split(".")[0] for name in imports_of(path)} & MODEL_LIBRARIES
        assert not found or relative(path).startswith("razer/models/"), f"{relative(path)} imports {found}"


def test_nothing_that_can_be_handed_over_is_unpickled():
    """Messages between the program's own processes, and files that `razer ablate` wrote a moment ago, are; the last one
    knows the name of an error."""
    users = {relative(path) for path in FILES if {"pickle", "dill", "shelve", "marshal"} & {*imports_of(path)}}
    of_own_processes = {
        "app/frames/prefetch_process.py", "app/live/publisher.py", "app/live/live_process.py",
        "app/ablation/perceived_walk.py", "app/batch/scene_evaluation.py", "app/engines/called_function.py",
        "app/engines/call_functions.py",
    }  # fmt: skip
    assert users == of_own_processes | {"razer/models/clip/open_clip_towers.py"}


def test_libraries_of_the_extra_serve_are_imported_where_maps_are_served():
    for path in FILES:
        found = {name.split(".")[0] for name in imports_of(path)} & SERVE_LIBRARIES
        assert not found or relative(path).startswith(SERVING_ROOMS), f"{relative(path)} imports {found}"


def test_no_import_cycles():
    graph = {module_name(path): imports_of(path) & OURS - {module_name(path)} for path in FILES}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"import cycle: {' -> '.join(error.args[1])}")


def test_verbs_import_no_verbs():
    for path in FILES:
        if relative(path).startswith("app/commands/"):
            verbs = {module for module in imports_of(path) if module.startswith("app.commands")}
            assert not verbs, f"{relative(path)} imports {verbs}"


def test_method_has_no_clock_and_does_not_print():
    for path in FILES:
        if path.relative_to(ROOT).parts[0] in ("razer", "slam"):
            assert not imports_of(path) & {"time", "rich", "logging", "matplotlib"}, relative(path)
            calls = [node for node in ast.walk(tree_of(path)) if isinstance(node, ast.Call)]
            assert not [c.lineno for c in calls if isinstance(c.func, ast.Name) and c.func.id == "print"], relative(
                path
            )


def names_in(node: ast.AST) -> set[str]:
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}


def holds_attribute(expression: ast.AST, tainted: set[str]) -> bool:
    """Whether the value may be, or may be cut from, a voxel attribute."""
    calls = [
        node.func.attr
        for node in ast.walk(expression)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    ]
    return bool(names_in(expression) & tainted or ATTRIBUTE_READERS & set(calls))


def bindings(function: ast.FunctionDef) -> Iterator[tuple[ast.AST, ast.AST]]:
    """(target, value) of everything that gives a value a name."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assign):
            yield from ((target, node.value) for target in node.targets)
        elif isinstance(node, ast.AnnAssign | ast.AugAssign | ast.NamedExpr) and node.value:
            yield node.target, node.value
        elif isinstance(node, ast.For | ast.comprehension):
            yield node.target, node.iter


def host_copies(tree: ast.Module) -> set[int]:
    """Lines where .numpy(), .cpu() or .to("cpu") is called on a voxel attribute, on what comes from one, or on
    a tensor that was handed in. Block keys are not attributes; counts leave by .tolist()."""
    found = set()
    for function in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)):
        arguments = [*function.args.args, *function.args.kwonlyargs]
        tainted = {a.arg for a in arguments if a.annotation and "Tensor" in ast.unparse(a.annotation)}
        size = -1
        while size != len(tainted):
            size = len(tainted)
            for target, value in bindings(function):
                if holds_attribute(value, tainted):
                    tainted |= names_in(target)
        found |= {
            call.lineno for call in ast.walk(function) if is_host_copy(call) and holds_attribute(call.func, tainted)
        }
    return found


def is_host_copy(node: ast.AST) -> bool:
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
        return False
    to_cpu = node.func.attr == "to" and any("cpu" in ast.unparse(argument).lower() for argument in node.args)
    return to_cpu or node.func.attr in ("numpy", "cpu")


def test_host_copies_of_attributes_are_found_and_of_keys_are_not():
    source = """
def bad(self, ids: Tensor, keys):
    label = self.attribute("label")
    part = label[3:]
    a = part.numpy()
    b = ids.cpu()
    c = [row.to("cpu") for row in part]
    d = self.pages.read(addresses, "tsdf")[0].cpu()

def good(self, keys, rows):
    host = keys.cpu().numpy()
    moved = self.attribute("label").to(self.device)
    return host, moved.tolist()
"""
    assert host_copies(ast.parse(source)) == {5, 6, 7, 8}


# By path pattern, so that a file cannot leave the fence by being moved. Models and metrics know no volume.
UNFENCED = ("razer/models/", "razer/metrics/")
METHOD_FILES = [
    path
    for path in sorted((ROOT / "razer").rglob("*.py"))
    if relative(path) not in MAY_COPY_TO_HOST and not relative(path).startswith(UNFENCED)
]


def test_the_fence_of_the_device_names_files_that_exist():
    assert {name for name in MAY_COPY_TO_HOST if not (ROOT / name).is_file()} == set()
    assert len(METHOD_FILES) > 40


@pytest.mark.parametrize("path", METHOD_FILES, ids=relative)
def test_voxel_attributes_stay_on_their_device(path):
    assert host_copies(tree_of(path)) == set()


# Arrows between the sub-packages of razer, and its modules that lie in none, as docs/architecture.md draws them.
def drawn_arrows() -> dict[str, set[str]]:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    block = re.search(r"<!-- arrows -->\n```text\n(.*?)```", text, re.DOTALL)
    assert block, "docs/architecture.md has lost its table of arrows"
    rows = (line.split("->") for line in block[1].splitlines() if line.strip())
    return {node.strip(): set(targets.split()) for node, targets in rows}


def room_of(module: str) -> str:
    """The first sub-package of razer that a module lies in, or the module itself."""
    return ".".join(module.split(".")[:2])


def arrows() -> dict[str, set[str]]:
    """What each room of razer imports of others."""
    found: dict[str, set[str]] = {}
    for path in FILES:
        if relative(path).startswith("razer/") and relative(path) != "razer/__init__.py":
            room = room_of(module_name(path))
            targets = {room_of(name) for name in imports_of(path) if name.startswith("razer.")}
            found.setdefault(room, set()).update(targets - {room})
    return found


def test_arrows_between_rooms_are_those_that_are_drawn():
    drawn = {f"razer.{node}": {f"razer.{t}" for t in targets} for node, targets in drawn_arrows().items()}
    for room, targets in arrows().items():
        assert targets <= drawn.get(room, set()), f"{room} imports {sorted(targets - drawn.get(room, set()))}"


def test_no_arrow_is_drawn_that_is_not_there():
    drawn = {f"razer.{node}": {f"razer.{t}" for t in targets} for node, targets in drawn_arrows().items()}
    there = arrows()
    assert {
        room: targets - there.get(room, set()) for room, targets in drawn.items() if targets - there.get(room, set())
    } == {}


def test_no_cycle_between_rooms():
    graph: dict[str, set[str]] = {}
    for path in FILES:
        room = room_graph_node(module_name(path))
        graph.setdefault(room, set()).update({room_graph_node(m) for m in imports_of(path) & OURS} - {room})
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"cycle of rooms: {' -> '.join(error.args[1])}")


def room_graph_node(module: str) -> str:
    """The package of a module; modules beside sub-packages stand for themselves."""
    package = module.rpartition(".")[0] or module
    has_rooms = any(
        child.is_dir() and (child / "__init__.py").exists() for child in (ROOT / package.replace(".", "/")).iterdir()
    )
    return module if has_rooms or (ROOT / module.replace(".", "/")).is_dir() else package


def test_extras_that_are_told_to_install_exist():
    with (ROOT / "pyproject.toml").open("rb") as file:
        extras = tomllib.load(file)["project"]["optional-dependencies"]
    texts = [path.read_text(encoding="utf-8") for path in [*FILES, ROOT / "README.md", *(ROOT / "docs").glob("*.md")]]
    named = {extra for text in texts for extra in re.findall(r"razer\[(\w+)\]", text)}
    assert named <= extras.keys()
    assert "transformers" in named
