"""What code and documents cite exists: in this repository steps, protocols, anchors, files; in the paper equations."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
ROOMS = ("app", "razer", "slam", "data_tools", "tests", "docs")
CODE = sorted(path for room in ROOMS for path in (ROOT / room).rglob("*.py") if HERE not in path.parents)
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md"), *(ROOT / ".github").rglob("*.md")])
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


def assert_no_faults(paths: Iterable[Path], faults_in: Callable[[Path, str], Iterator[str]]) -> None:
    """Fail with all that is wrong, each with its file."""
    faults = [f"{relative(path)}: {fault}" for path in paths for fault in faults_in(path, text_of(path))]
    assert not faults, "\n".join(faults)


def test_cited_equations_and_sections_are_in_the_paper():
    def missing(path: Path, text: str) -> Iterator[str]:
        for number in numbered(r"RAZER eqs?\.", text):
            if number != "N" and not 1 <= int(number) <= RAZER_EQUATIONS:
                yield f"RAZER eq. {number}"
        for pair in re.findall(r"RAZER sections? ([IVX]+(?:-[A-Z])?)(?:(?: to | and |, )([IVX]+(?:-[A-Z])?))?", text):
            yield from (f"RAZER section {section}" for section in pair if section and section not in RAZER_SECTIONS)

    assert_no_faults(FILES, missing)


def test_equations_and_sections_name_their_paper():
    def nameless(path: Path, text: str) -> Iterator[str]:
        for match in re.finditer(r"\b(?:eqs?\. ?\(?\d+|sections? [IVX]+(?:-[A-Z])?\b)", text):
            before = text[max(0, match.start() - 40) : match.start()]
            if not re.search(r"(RAZER( sections? [IVX\w-]+,)?|(19|20)\d\d,?) $", before):
                yield f"whose? ...{before}{match[0]}"

    # The page of the method is about the paper, and says so once.
    assert_no_faults([path for path in FILES if relative(path) != "docs/method.md"], nameless)


def test_cited_steps_and_protocols_have_a_heading():
    steps = {heading.split(":")[0] for heading in headings(ROOT / "docs" / "method.md")}
    protocols = {heading.split(":")[0] for heading in headings(ROOT / "docs" / "evaluation.md")}

    def missing(path: Path, text: str) -> Iterator[str]:
        for number in numbered(r"method\.md`?,? \(?steps?", text):
            if number != "N" and f"Step {number}" not in steps:
                yield f"method.md step {number}"
        for letter in numbered(r"\b[Pp]rotocols?", text):
            if f"Protocol {letter}" not in protocols:
                yield f"protocol {letter}"

    assert_no_faults(FILES, missing)


def test_documents_named_in_code_are_in_the_repository():
    pages = {page.name for page in (ROOT / "docs").glob("*.md")}

    def missing(path: Path, text: str) -> Iterator[str]:
        for name in re.findall(r'(?<!")(?<![\w./-])[\w./-]*\b\w+\.md\b', text):
            if (name in pages or name.startswith("docs/")) and not (ROOT / name).is_file():
                yield f"{name} is no file of the repository (docs/{name}?)"
        for page, name in re.findall(r"(docs/[\w/]+\.md)#([\w-]+)", text):
            if name not in map(anchor, headings(ROOT / page)):
                yield f"{page}#{name}"
        for page, heading in re.findall(r'(docs/[\w/]+\.md)`?, "([^"]+)"', text):
            if heading not in headings(ROOT / page):
                yield f'{page}, "{heading}"'

    assert_no_faults(CODE, missing)


def test_nothing_outside_the_repository_is_cited():
    def outside(path: Path, text: str) -> Iterator[str]:
        yield from re.findall(r"(?:\.\./)+(?:shared|design|paper)\b\S*|\b(?:house|users|roadmap)\.md", text)

    assert_no_faults(FILES, outside)


def test_links_lead_somewhere():
    def broken(path: Path, text: str) -> Iterator[str]:
        for target in LINK.findall(text):
            if "://" in target or target.startswith("mailto:"):
                continue
            file, _, name = target.partition("#")
            page = (path.parent / file).resolve() if file else path
            generated = page.parent == ROOT / "docs" and page.name in GENERATED
            if ROOT not in page.parents or not (page.exists() or generated):
                yield f"{target}: no such file"
            elif name and name not in map(anchor, headings(page)):
                yield f"{target}: no such heading"

    assert_no_faults(PAGES, broken)


def test_files_named_in_pages_exist():
    named = r"(?<![\w/.])((?:tests|docs|app|razer|slam|data_tools)/[\w/]+\.(?:py|md|toml|png))"

    def missing(path: Path, text: str) -> Iterator[str]:
        yield from (name for name in re.findall(named, text) if not (ROOT / name).is_file())

    assert_no_faults(PAGES, missing)


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
