"""Programs of README and pages before a type checker, as a reader would save them."""

import re

import pytest

from tests.docs.test_docs import PAGES
from tests.support.shared import REPOSITORY
from tests.support.type_checker import UNTYPED, complaints

_BLOCK = re.compile(r"^```(?:\{code-block\} )?python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NAME = re.compile(r"# ([\w./-]+\.py)\n")


def programs():
    """Text of each program by the name of its file: blocks without a name are one program, that of their page."""
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


def test_every_block_is_found():
    texts = [page.read_text() for page in PAGES]
    assert sum(len(_BLOCK.findall(text)) for text in texts) == sum(
        len(re.findall(r"^```.*python", text, re.MULTILINE)) for text in texts
    )


@pytest.mark.slow
def test_programs_of_the_pages_pass_the_type_checker(tmp_path):
    folder = tmp_path / "programs"
    folder.mkdir()
    for name, text in programs().items():
        (folder / name).write_text(text)
    assert complaints(folder, *UNTYPED) == []
    wrong = folder / "mean.py"  # of the README
    wrong.write_text(wrong.read_text().replace("source(seed=1)", 'source(seed=1, order="backward")'))
    assert [re.sub(r".*/", "", line).split(": ")[:2] for line in complaints(folder, *UNTYPED)] == [
        ["mean.py:3", "error"]
    ]
