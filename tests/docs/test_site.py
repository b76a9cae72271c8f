"""The site: one page for every public name, a gallery of short programs, shell blocks that say so."""

from __future__ import annotations

import ast
import importlib.util
import json
import re
from collections import Counter
from pathlib import Path

import pytest

import aomc_sky
from tests.support.shared import REPOSITORY

DOCS = REPOSITORY / "docs"
TOPICS = sorted((DOCS / "api").glob("*.md"))
GALLERY = sorted((REPOSITORY / "examples" / "gallery").glob("*.py"))
_found = importlib.util.spec_from_file_location("check_site", DOCS / "check_site.py")
assert _found is not None
assert _found.loader is not None
check_site = importlib.util.module_from_spec(_found)
_found.loader.exec_module(check_site)
PAGES = [p for p in sorted([*REPOSITORY.glob("*.md"), *DOCS.rglob("*.md")]) if "_build" not in p.parts]


def defined(topic: Path) -> list[str]:
    """Names that a page defines, as one writes them after `aomc_sky.`."""
    names = re.findall(r"^\.\. auto(?:function|class|exception):: (\S+)$", topic.read_text(), re.MULTILINE)
    return [name.removeprefix("aomc_sky.") for name in names]


def listed(topic: Path) -> list[str]:
    """Names in the table at the head of a page, which the overview shows too."""
    table = topic.read_text().partition("<!-- names -->")[2].partition("<!-- definitions -->")[0]
    return re.findall(r"^   ~?([\w.]+)$", table, re.MULTILINE)


def public_names() -> list[str]:
    """What `import aomc_sky` offers, modules by what they say is theirs."""
    modules = aomc_sky._PUBLIC_MODULES
    names = [name for name in aomc_sky.__all__ if name != "__version__" and name not in modules]
    for module in modules:
        ours = getattr(aomc_sky, module)
        names += [f"{module}.{name}" for name in getattr(ours, "__all__", []) if callable(getattr(ours, name))]
    return names


def test_every_public_name_stands_on_exactly_one_page() -> None:
    on_pages = Counter(name for topic in TOPICS for name in defined(topic))
    assert {name: on_pages[name] for name in public_names()} == dict.fromkeys(public_names(), 1)
    assert max(on_pages.values()) == 1


@pytest.mark.parametrize("topic", TOPICS, ids=[topic.stem for topic in TOPICS])
def test_table_of_a_page_lists_what_the_page_defines(topic: Path) -> None:
    whole_modules = re.findall(r"^\.\. automodule:: aomc_sky\.(\S+)\n   :members:$", topic.read_text(), re.MULTILINE)
    single = [name for name in listed(topic) if not name.startswith(tuple(f"{m}." for m in whole_modules))]
    assert single == defined(topic)


def test_overview_shows_the_table_of_every_page() -> None:
    overview = (DOCS / "api.md").read_text()
    names = [f"api/{topic.stem}" for topic in TOPICS]
    assert sorted(re.findall(r"^(api/\w+)$", overview, re.MULTILINE)) == names
    assert sorted(re.findall(r"^```\{include\} (\S+)\.md$", overview, re.MULTILINE)) == names


@pytest.mark.parametrize("program", GALLERY, ids=[program.stem for program in GALLERY])
def test_program_of_the_gallery_is_short_and_uses_public_names(program: Path) -> None:
    text = program.read_text()
    tree = ast.parse(text)
    head = ast.get_docstring(tree)
    assert head is not None
    title, rule = head.splitlines()[:2]
    assert rule == "=" * len(title)
    body = text.split('"""', 2)[2]
    lines = [line for line in body.splitlines() if line.strip() and not re.match(r"#|import |from ", line)]
    assert 2 <= len(lines) <= 20, len(lines)
    used = {n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and ast.unparse(n.value) == "sky"}
    taken = {
        a.name for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.module == "aomc_sky" for a in n.names
    }
    assert used | taken <= set(aomc_sky.__all__)
    assert used | taken


def test_gallery_has_ten_programs() -> None:
    assert len(GALLERY) >= 10


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(REPOSITORY)) for page in PAGES])
def test_commands_stand_in_blocks_of_a_shell(page: Path) -> None:
    blocks = re.findall(r"^```(\S*)[^\n]*\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    starts = re.compile(r"^(?:\$ |(?:\S*/)?(?:aomc-sky|python3?|pip|gcc|bash) )", re.MULTILINE)
    assert [block for language, block in blocks if language in ("", "text") and starts.search(block)] == []


HUBS = ["start", "howto/index", "reference", "models/index", "accuracy", "formats/index"]


@pytest.mark.parametrize("hub", HUBS)
def test_page_that_leads_on_says_what_each_of_its_pages_answers(hub: str) -> None:
    text = (DOCS / f"{hub}.md").read_text()
    prose, _, tree = text.partition("```{toctree}")
    below = re.findall(r"^([./\w]+)$", tree, re.MULTILINE)
    assert below
    assert [page for page in below if f"({page}.md)" not in prose] == []


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """The least of a site that is as it should be."""
    pages = sorted({*check_site.FIRST.values(), "changelog"})
    entries = {word: [[pages.index(page), "index-0", True]] for word, page in check_site.FIRST.items()}
    index = json.dumps({"docnames": pages, "indexentries": entries})
    (tmp_path / "searchindex.js").write_text(f"Search.setIndex({index})")
    (tmp_path / "index.html").write_text('<a href="https://elsewhere">x</a><img alt="" src="sky.png">')
    (tmp_path / "sky.png").write_bytes(b"")
    (tmp_path / "site.css").write_text('a { background: url("data:image/svg+xml,https://x"); }')
    return tmp_path


def test_good_site_passes(site: Path) -> None:
    assert check_site.complaints(site) == []


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("a.html", '<script src="https://cdn/x.js"></script>', "a.html: https://cdn/x.js"),
        ("a.html", '<link rel="stylesheet" href="//cdn/x.css">', "a.html: //cdn/x.css"),
        ("a.css", "@import 'https://fonts/x';", "a.css: https://fonts/x"),
        ("a.css", "@font-face { src: url(https://fonts/x.woff2); }", "a.css: https://fonts/x.woff2"),
        ("a.html", '<img alt="" src="lost.png">', "a.html: lost.png"),
        ("searchindex.js", 'Search.setIndex({"docnames": [], "indexentries": {}})', "weighting: [], not conventions"),
    ],
)
def test_what_is_wrong_with_a_site_is_said(site: Path, name: str, text: str, complaint: str) -> None:
    (site / name).write_text(text)
    assert complaint in check_site.complaints(site)
