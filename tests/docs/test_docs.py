"""The pages say what is true: commands, links, options, names; public names are known to the type checker."""

import ast
import pydoc
import re
import tomllib
from importlib.metadata import version

import pytest

import aomc_sky
from tests.support.shared import REPOSITORY
from tests.support.type_checker import UNTYPED, complaints

README = (REPOSITORY / "README.md").read_text()
RUN_COMMAND = (
    "python3 -m venv .venv && .venv/bin/pip install . && "
    ".venv/bin/aomc-sky run inputs/clear_day/amc.inp --seed 1 --out out"
)
TEST_COMMAND = (
    'python3 -m venv .venv && .venv/bin/pip install -e ".[test]" && '
    ".venv/bin/python -m pytest -q -n auto --dist loadfile"
)

PAGES = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "inputs/**/*.md", "bench/*.md", "tests/data/*.md")
    for path in REPOSITORY.glob(pattern)
    if not {"_build", "gallery"} & set(path.parts)
)


def test_readme_has_exactly_the_two_set_up_commands():
    blocks = re.findall(r"^```sh\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
    assert "".join(blocks).splitlines() == [RUN_COMMAND, TEST_COMMAND]


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(REPOSITORY)) for page in PAGES])
def test_links_of_a_page_lead_somewhere(page):
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    found = re.findall(r"\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"", text)
    targets = [t for t in map("".join, found) if not re.match(r"[a-z]+://|#|mailto:", t)]
    missing = [t for t in targets if not (page.parent / t.partition("#")[0]).exists()]
    assert missing == []


def test_exit_codes_of_the_errors_stand_in_the_manual():
    from aomc_sky import errors

    kinds = [kind for kind in vars(errors).values() if isinstance(kind, type)]
    codes = {kind.exit_code for kind in kinds if issubclass(kind, errors.AomcSkyError)}
    rows = re.findall(r"^\| (\d+) \|", (REPOSITORY / "docs/cli.md").read_text(), re.MULTILINE)
    assert codes | {0, 130} == {int(row) for row in rows}


def test_every_citation_has_its_entry_and_every_entry_its_citation():
    entries = set(re.findall(r"^@\w+\{(\w+),", (REPOSITORY / "docs/references.bib").read_text(), re.MULTILINE))
    pages = "".join(page.read_text() for page in PAGES if "docs" in page.parts)
    cited = {key.strip() for keys in re.findall(r"\{cite\}`([^`]+)`", pages) for key in keys.split(",")}
    assert cited == entries


def test_names_that_the_package_loads_are_those_of_the_stub():
    stub = ast.parse((REPOSITORY / "src/aomc_sky/__init__.pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    names = {alias.asname or alias.name: node.module for node in imports for alias in node.names}
    homes = {name: f"aomc_sky.{module}" for name, module in {**aomc_sky._PUBLIC, **aomc_sky._OLD}.items()}
    homes |= {name: f"aomc_sky.{module}".rpartition(".")[0] for name, module in aomc_sky._PUBLIC_MODULES.items()}
    assert names == homes
    with pytest.raises(AttributeError, match="no attribute 'no_such_name'"):
        aomc_sky.no_such_name  # noqa: B018


@pytest.mark.parametrize("name", aomc_sky._OLD)
def test_old_name_works_for_one_version_and_says_the_new_one(name):
    new = f"aomc_sky.{aomc_sky._OLD[name]}.{name}"
    with pytest.warns(DeprecationWarning, match=f"aomc_sky.{name} goes with version 0.6: write {new}$"):
        found = getattr(aomc_sky, name)
    assert found is pydoc.locate(new)
    assert name not in dir(aomc_sky)


def test_version_stands_in_one_place():
    assert version("aomc-sky") == aomc_sky.__version__
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    assert "version" not in project
    assert "version" in project["dynamic"]
    cited = re.search(r"^version: (\S+)$", (REPOSITORY / "CITATION.cff").read_text(), re.MULTILINE)
    assert cited[1] == aomc_sky.__version__
    assert f"## {aomc_sky.__version__}" in (REPOSITORY / "CHANGELOG.md").read_text()
    assert f"*aomc-sky {aomc_sky.__version__}*" in README
    cite = (REPOSITORY / "docs" / "cite.md").read_text()
    assert cite.count(aomc_sky.__version__) == len(re.findall(r"\d+\.\d+\.\d+", cite)) == 2


def test_streams_of_the_version_stand_in_the_changelog():
    from aomc_sky.plan.streams import STREAM_VERSION

    streams = (REPOSITORY / "CHANGELOG.md").read_text().split("### Streams", 1)[1]
    assert f"`{STREAM_VERSION}`" in streams


def test_the_newest_version_is_read_in_three_minutes():
    newest = re.split(r"^## ", (REPOSITORY / "CHANGELOG.md").read_text(), flags=re.MULTILINE)[1]
    assert newest.startswith(aomc_sky.__version__) or "(unreleased)" in newest.splitlines()[0]
    assert len(newest.split()) <= 700


_BLOCK = re.compile(r"^```(?:\{code-block\} )?python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NAME = re.compile(r"# ([\w./-]+\.py)\n")


def programs():
    """Programs of README and pages, by the name under which a reader saves them.

    Blocks without a name are one program, that of their page.
    """
    found = {}
    for page in PAGES:
        parts = []
        for text in _BLOCK.findall(page.read_text()):
            if (named := _NAME.match(text)) is None:
                parts.append(text)
            else:
                name = named[1].rpartition("/")[2]
                assert name not in found, f"{page}: another page has a program of the name {name}"
                found[name] = text
        if parts:
            place = page.relative_to(REPOSITORY).with_suffix("")
            found["_".join(place.parts).replace("-", "_").lower() + "_page.py"] = "".join(parts)
    return found


def test_every_block_of_python_is_found():
    text = "\n".join(page.read_text() for page in PAGES)
    assert len(_BLOCK.findall(text)) == len(re.findall(r"^```.*python", text, re.MULTILINE))


@pytest.mark.slow
def test_programs_of_the_pages_pass_the_type_checker(tmp_path):
    folder = tmp_path / "programs"
    folder.mkdir()
    for name, text in programs().items():
        (folder / name).write_text(text)
    assert complaints(folder, *UNTYPED) == []
    wrong = folder / "mean.py"  # of the README
    wrong.write_text(wrong.read_text().replace("source(seed=1)", 'source(seed=1, order="backward")'))
    (line,) = complaints(folder, *UNTYPED)
    assert "/mean.py:3: error: " in line
