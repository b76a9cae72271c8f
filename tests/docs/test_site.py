"""The site: one page for every public name, a gallery of short programs, shell blocks that say so."""

import ast
import json
import re
from collections import Counter

import pytest

import aomc_sky
from tests.docs.test_docs import PAGES
from tests.support.public_names import public_names
from tests.support.shared import REPOSITORY, script

DOCS = REPOSITORY / "docs"
TOPICS = sorted(topic.stem for topic in (DOCS / "api").glob("*.md"))
GALLERY = sorted((REPOSITORY / "examples" / "gallery").glob("*.py"))


check_site = script(DOCS / "check_site.py")
topics = script(DOCS / "extensions" / "topics.py")


def test_every_public_name_stands_in_one_topic_and_every_topic_in_the_overview():
    in_topics = Counter(name.removeprefix("aomc_sky.") for topic in TOPICS for name in topics.names_of(topic))
    assert {name: in_topics[name] for name in public_names()} == dict.fromkeys(public_names(), 1)
    assert max(in_topics.values()) == 1
    overview = (DOCS / "api.md").read_text()
    assert sorted(re.findall(r"^api/(\w+)$", overview, re.MULTILINE)) == TOPICS
    assert sorted(re.findall(r"^```\{names\} (\w+)$", overview, re.MULTILINE)) == TOPICS


@pytest.mark.parametrize("program", GALLERY, ids=[program.stem for program in GALLERY])
def test_program_of_the_gallery_has_a_title_and_uses_public_names(program):
    tree = ast.parse(program.read_text())
    title, rule = ast.get_docstring(tree).splitlines()[:2]
    assert rule == "=" * len(title)
    used = {n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and ast.unparse(n.value) == "sky"}
    imports = [n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.module == "aomc_sky"]
    taken = {alias.name for n in imports for alias in n.names}
    assert used | taken <= {*aomc_sky.__all__, *aomc_sky._PUBLIC_MODULES}
    assert used | taken


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(REPOSITORY)) for page in PAGES])
def test_commands_stand_in_blocks_of_a_shell(page):
    blocks = re.findall(r"^```(\S*)[^\n]*\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    starts = re.compile(r"^(?:\$ |(?:\S*/)?(?:aomc-sky|python3?|pip|gcc|bash) )", re.MULTILINE)
    assert [block for language, block in blocks if language in ("", "text") and starts.search(block)] == []


@pytest.fixture
def site(tmp_path):
    pages = sorted({*check_site.FIRST.values(), "changelog"})
    entries = {word.lower(): [[pages.index(page), "index-0", True]] for word, page in check_site.FIRST.items()}
    index = json.dumps({"docnames": pages, "indexentries": entries})
    (tmp_path / "searchindex.js").write_text(f"Search.setIndex({index})")
    (tmp_path / "index.html").write_text('<a href="https://elsewhere">x</a><img alt="" src="sky.png">')
    (tmp_path / "sky.png").write_bytes(b"")
    (tmp_path / "site.css").write_text('a { background: url("data:image/svg+xml,https://x"); }')
    return tmp_path


def test_a_good_site_passes(site):
    light, dark = (f'<img class="only-{mode}" alt="figure" src="data:,">' for mode in ("light", "dark"))
    (site / "a.html").write_text(light + dark)
    assert check_site.complaints(site) == []


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("a.html", '<script src="https://cdn/x.js"></script>', "a.html: https://cdn/x.js"),
        ("a.html", '<link rel="stylesheet" href="//cdn/x.css">', "a.html: //cdn/x.css"),
        ("a.css", "@import 'https://fonts/x';", "a.css: https://fonts/x"),
        ("a.css", "@font-face { src: url(https://fonts/x.woff2); }", "a.css: https://fonts/x.woff2"),
        ("a.html", '<img alt="" src="lost.png">', "a.html: lost.png"),
        ("a.html", '<img alt="figure" class="only-light" src="data:,">', "a.html: a picture has no twin for dark mode"),
        ("a.html", '<img src="_images/sphx_glr_1.png">', "a.html: a picture has no twin for dark mode"),
        ("searchindex.js", 'Search.setIndex({"docnames": [], "indexentries": {}})', "weighting: [], not conventions"),
    ],
)
def test_what_is_wrong_with_a_site_is_said(site, name, text, complaint):
    (site / name).write_text(text)
    assert complaint in check_site.complaints(site)
