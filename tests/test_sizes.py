"""How long files and functions may be, and how full a package."""

from __future__ import annotations

import ast

import pytest

from tests.test_layering import FILES, relative, tree_of

VAGUE_NAMES = {"utils.py", "util.py", "common.py", "base.py", "helpers.py", "helper.py", "misc.py"}
MAX_FILE_LINES = 300
MAX_FUNCTION_LINES = 50
MEDIAN_FILE_LINES = 90
MANY_FUNCTIONS_LINES = 16  # nine in ten functions are no longer
MAX_MODULES = 14  # of a package, __init__ included


@pytest.mark.parametrize("path", FILES, ids=relative)
def test_files_and_functions_are_short(path):
    assert path.name not in VAGUE_NAMES
    assert len(path.read_text(encoding="utf-8").splitlines()) <= MAX_FILE_LINES
    functions = [node for node in ast.walk(tree_of(path)) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    long = [
        f"{node.name}: {node.end_lineno - node.lineno + 1}"
        for node in functions
        if node.end_lineno - node.lineno >= MAX_FUNCTION_LINES
    ]
    assert long == []


def test_most_files_and_functions_are_shorter_still():
    sizes = sorted(len(path.read_text(encoding="utf-8").splitlines()) for path in FILES)
    assert sizes[len(sizes) // 2] <= MEDIAN_FILE_LINES
    functions = [node for path in FILES for node in ast.walk(tree_of(path)) if isinstance(node, ast.FunctionDef)]
    lengths = sorted(node.end_lineno - node.lineno + 1 for node in functions if node.end_lineno)
    assert lengths[int(0.9 * len(lengths))] <= MANY_FUNCTIONS_LINES


@pytest.mark.parametrize("package", sorted({path.parent for path in FILES}), ids=relative)
def test_a_package_has_few_modules_and_says_what_it_is(package):
    assert len(list(package.glob("*.py"))) <= MAX_MODULES
    assert ast.get_docstring(tree_of(package / "__init__.py"))
