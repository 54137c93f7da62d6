"""What code and documents cite exists: in this repository steps, protocols, anchors, files; in the paper equations."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
ROOMS = ("app", "razer", "slam", "data_tools", "tests", "docs")
CODE = sorted(path for room in ROOMS for path in (ROOT / room).rglob("*.py") if HERE not in path.parents)
PAGES = sorted(
    [*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md"), *(ROOT / ".github").rglob("*.md")],
)
FILES = [*CODE, *PAGES]
# The paper numbers what stands in `equation` environments, of which it has fifteen: V(p) is the first, the support
# ratio the last. Two more displayed formulas bear no number.
RAZER_EQUATIONS = 15
# I introduction, II related work, III problem, IV the method (A volume, B detection, C association, D box updates,
# E embeddings, F semantic map, G integration, H instance segmentation, I retrieval), V experiments, VI conclusion.
RAZER_SECTIONS = {"I", "II", "III", "IV", "V", "VI", *(f"IV-{s}" for s in "ABCDEFGHI"), *(f"V-{s}" for s in "ABCDE")}
# Pages that docs/site_pages.py makes; the site's own strict build looks at links to them.
GENERATED = {"changes.md", "contributing.md", "examples.md", "settings.md"}
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@cache
def text_of(path: Path) -> str:
    """The text with each run of white space as one blank, so that a citation may be broken over lines."""
    return re.sub(r"\s+(?:# )?", " ", path.read_text(encoding="utf-8"))


@cache
def headings(path: Path) -> tuple[str, ...]:
    """The headings of a page, without what stands in code blocks."""
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return tuple(re.findall(r"^#+ (.+)$", text, re.MULTILINE))


def anchor(heading: str) -> str:
    """The anchor of a heading, as the site and the usual viewers of repositories make it."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")


def numbered(pattern: str, text: str) -> Iterator[str]:
    """What follows the pattern: "3", and both of "3 to 5", "3 and 4", "3-5"."""
    for match in re.finditer(pattern + r" (\d+|[A-Z])\b(?:(?: to | and |, |-)(\d+|[A-Z])\b)?", text):
        yield from filter(None, match.groups())


def test_parser_on_known_cases():
    assert list(numbered(r"docs/method\.md steps?", "see docs/method.md step 8.")) == ["8"]
    assert list(numbered("RAZER eqs?\\.", "(RAZER eqs. 9 to 11) RAZER eq. 8, where")) == ["9", "11", "8"]
    assert anchor("Protocol A: instances on SceneNN") == "protocol-a-instances-on-scenenn"
    assert anchor("A detector of your own: `yolo` and `names`") == "a-detector-of-your-own-yolo-and-names"


@pytest.mark.parametrize("path", FILES, ids=relative)
def test_cited_equations_and_sections_are_in_the_paper(path):
    text = text_of(path)
    for number in numbered(r"RAZER eqs?\.", text):
        assert number == "N" or 1 <= int(number) <= RAZER_EQUATIONS, f"RAZER eq. {number}"
    cited = re.findall(r"RAZER sections? ([IVX]+(?:-[A-Z])?)(?:(?: to | and |, )([IVX]+(?:-[A-Z])?))?", text)
    assert {section for pair in cited for section in pair if section} <= RAZER_SECTIONS


# The page of the method is about the paper, and says so once.
@pytest.mark.parametrize("path", [p for p in FILES if relative(p) != "docs/method.md"], ids=relative)
def test_equations_and_sections_name_their_paper(path):
    text = text_of(path)
    for match in re.finditer(r"\b(?:eqs?\. ?\(?\d|sections? [IVX]+(?:-[A-Z])?\b)", text):
        before = text[max(0, match.start() - 40) : match.start()]
        assert re.search(r"(RAZER( sections? [IVX\w-]+,)?|(19|20)\d\d,?) $", before), f"whose? ...{before}{match[0]}"


@pytest.mark.parametrize("path", FILES, ids=relative)
def test_cited_steps_and_protocols_have_a_heading(path):
    text = text_of(path)
    steps = {heading.split(":")[0] for heading in headings(ROOT / "docs" / "method.md")}
    for number in numbered(r"method\.md`?,? \(?steps?", text):
        assert number == "N" or f"Step {number}" in steps, f"method.md step {number}"
    protocols = {heading.split(":")[0] for heading in headings(ROOT / "docs" / "evaluation.md")}
    for letter in numbered(r"\b[Pp]rotocols?", text):
        assert f"Protocol {letter}" in protocols, f"protocol {letter}"


@pytest.mark.parametrize("path", CODE, ids=relative)
def test_documents_named_in_code_are_in_the_repository(path):
    pages = {page.name for page in (ROOT / "docs").glob("*.md")}
    for name in re.findall(r'(?<!")(?<![\w./-])[\w./-]*\b\w+\.md\b', text_of(path)):
        if name in pages or name.startswith("docs/"):
            assert (ROOT / name).is_file(), f"{name} is no file of the repository (docs/{name}?)"
    for page, name in re.findall(r"(docs/[\w/]+\.md)#([\w-]+)", text_of(path)):
        assert name in map(anchor, headings(ROOT / page)), f"{page}#{name}"
    for page, heading in re.findall(r'(docs/[\w/]+\.md)`?, "([^"]+)"', text_of(path)):
        assert heading in headings(ROOT / page), f'{page}, "{heading}"'


@pytest.mark.parametrize("path", FILES, ids=relative)
def test_nothing_outside_the_repository_is_cited(path):
    found = re.findall(r"(?:\.\./)+(?:shared|design|paper)\b\S*|/work/\S*|\b(?:house|users|roadmap)\.md", text_of(path))
    assert found == []


@pytest.mark.parametrize("path", PAGES, ids=relative)
def test_links_lead_somewhere(path):
    for target in LINK.findall(path.read_text(encoding="utf-8")):
        if "://" in target or target.startswith("mailto:"):
            continue
        file, _, name = target.partition("#")
        page = (path.parent / file).resolve() if file else path
        generated = page.parent == ROOT / "docs" and page.name in GENERATED
        assert page.exists() or generated, f"{target}: no such file"
        assert ROOT in page.parents, f"{target}: outside the repository"
        if name:
            assert name in map(anchor, headings(page)), f"{target}: no such heading"


@pytest.mark.parametrize("path", PAGES, ids=relative)
def test_files_named_in_pages_exist(path):
    named = re.findall(
        r"(?<![\w/.])((?:tests|docs|app|razer|slam|data_tools)/[\w/]+\.(?:py|md|toml|png))", text_of(path)
    )
    assert [name for name in named if not (ROOT / name).is_file()] == []


def test_anchors_are_the_same_on_the_site():
    for path in PAGES:
        for name in map(anchor, headings(path)):
            assert "--" not in name, f"{relative(path)}: #{name} has another anchor on the site"


def test_the_table_of_equations_names_each_once_and_what_computes_it():
    text = (ROOT / "docs" / "method.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([\d, ]+) \| .* \| (`razer.*`) \|$", text, re.MULTILINE)
    numbers = [int(number) for cited, _ in rows for number in cited.split(", ")]
    assert numbers == list(range(1, RAZER_EQUATIONS + 1))
    for module, name in (target.rsplit(".", 1) for _, cell in rows for target in re.findall(r"`([\w.]+)`", cell)):
        path = ROOT.joinpath(*module.split("."))
        source = (path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).read_text(encoding="utf-8")
        assert re.search(rf"^(?:class|def) {name}\b", source, re.MULTILINE), f"{module} has no {name}"
