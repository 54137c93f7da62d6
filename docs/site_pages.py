"""Pages that the site gets beside those of docs/: README, changes, contributing, examples, settings, Python interface.

A hook of mkdocs. The README and its kin are written for the repository, so their links are turned to those of the
site; the pages of the Python interface list the face of each package, and the modules that those who write a
plug-in need. Nothing is imported: all is read from the source.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
# Page of the site -> file of the repository; a link to the one is a link to the other.
ROOT_PAGES = {"index.md": "README.md", "changes.md": "CHANGELOG.md", "contributing.md": ".github/CONTRIBUTING.md"}
# What is public besides a package's own face: the settings, and what a plug-in must look like.
PUBLIC_MODULES = {
    "razer": ("razer.config", "razer.models", "razer.errors"),
    "slam": ("slam.poses", "slam.report"),
    "data_tools": ("data_tools.recordings.sequence",),
}
SETTINGS = (
    "razer.config.volume",
    "razer.config.lifting",
    "razer.config.association",
    "razer.config.bank",
    "razer.config.maintenance",
    "razer.config.reintegration",
    "slam.config",
    "app.settings.run_config",
    "app.timeline.config",
)
LINK = re.compile(r"(!?\[[^\]]*\])\(([^)\s#]+)([^)\s]*)\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages."""
    for page, source in ROOT_PAGES.items():
        files.append(File.generated(config, page, content=with_site_links(ROOT / source)))
    for package in PUBLIC_MODULES:
        files.append(File.generated(config, f"api/{package}.md", content=interface_page(package)))
    files.append(File.generated(config, "examples.md", content=examples_page()))
    files.append(File.generated(config, "settings.md", content=settings_page()))
    return files


def with_site_links(source: Path) -> str:
    """A page of the repository with its relative links turned to pages of the site; what the site does not show is
    named without a link."""
    pages = {file: page for page, file in ROOT_PAGES.items()} | {"docs/examples": "examples.md"}

    def turned(match: re.Match[str]) -> str:
        text, target, anchor = match.groups()
        if "://" in target or target.startswith("mailto:"):
            return match[0]
        path = (source.parent / target).resolve().relative_to(ROOT).as_posix()
        if path not in pages and not path.startswith("docs/"):
            return text[text.index("[") + 1 : -1]
        return f"{text}({pages.get(path) or path.removeprefix('docs/')}{anchor})"

    return LINK.sub(turned, source.read_text(encoding="utf-8"))


def interface_page(package: str) -> str:
    """The public names of a package, then the modules that belong to its face."""
    lines = [f"# {package}", "", ast.get_docstring(tree_of(f"{package}")) or "", ""]
    for name, module in sorted(face_of(package).items()):
        if module not in PUBLIC_MODULES[package]:
            lines += [f"::: {module}.{name}", ""]
    for module in PUBLIC_MODULES[package]:
        if module_file(module).exists():
            lines += [f"::: {module}", "    options:", "      show_root_full_path: true", ""]
    return "\n".join(lines)


def face_of(package: str) -> dict[str, str]:
    """Name -> module of what a package offers: its imports for type checkers, since the others are lazy."""
    return {
        alias.name: statement.module or package
        for node in tree_of(package).body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for statement in node.body
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    }


def module_file(module: str) -> Path:
    """The file of a module, or of a package's face."""
    path = ROOT.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def tree_of(module: str) -> ast.Module:
    """The parsed source of a module."""
    return ast.parse(module_file(module).read_text(encoding="utf-8"))


def settings_page() -> str:
    """Every setting with its default and meaning, by the class that holds it."""
    lines = [
        "# Settings",
        "",
        "As `razer config` prints them with their ranges; `--set section.name=value` changes one.",
        "",
    ]
    for module in filter(lambda module: module_file(module).exists(), SETTINGS):
        for node in tree_of(module).body:
            if isinstance(node, ast.ClassDef) and (rows := list(setting_rows(node))):
                about = (ast.get_docstring(node) or "").replace("\n", " ")
                lines += [
                    f"## {node.name}",
                    "",
                    about,
                    "",
                    "| setting | default | meaning |",
                    "|---|---|---|",
                    *rows,
                    "",
                ]
    return "\n".join(lines)


def setting_rows(settings: ast.ClassDef) -> Iterator[str]:
    """A row of a table for each field of a class of settings."""
    for node in settings.body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.value, ast.Call) and node.value.args:
            keywords = {word.arg: word.value for word in node.value.keywords}
            if isinstance(about := keywords.get("description"), ast.Constant):
                meaning = str(about.value).replace("|", "\\|")
                yield f"| `{ast.unparse(node.target)}` | `{ast.unparse(node.value.args[0])}` | {meaning} |"


def examples_page() -> str:
    """The programs of docs/examples, word for word, each under the first line of its docstring."""
    lines = ["# Examples", "", "Each of these programs is run by the tests.", ""]
    for path in sorted((ROOT / "docs" / "examples").glob("*.py")):
        source = path.read_text(encoding="utf-8")
        about = (ast.get_docstring(ast.parse(source)) or path.stem).splitlines()[0].rstrip(".")
        lines += [f"## {about}", "", f"`docs/examples/{path.name}`", "", "```python", source.rstrip(), "```", ""]
    return "\n".join(lines)
