"""Topics of the Python reference: pages of docs/api, each with a table of names that have pages of their own."""

from __future__ import annotations

import re
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "api"
_TABLE = re.compile(r"^\.\. autosummary::\n.*?(?=^```$)", re.MULTILINE | re.DOTALL)


def names_of(page: str) -> list[str]:
    """Full names in the table of a topic."""
    table = _TABLE.search((FOLDER / f"{page}.md").read_text())
    return (
        [] if table is None else [f"aomc_sky.{name}" for name in re.findall(r"^   ~?([\w.]+)$", table[0], re.MULTILINE)]
    )


def topic_of() -> dict[str, dict[str, str]]:
    """The page and the title of the topic to which every name belongs."""
    pages = {path.stem: path.read_text().partition("\n")[0].removeprefix("# ") for path in FOLDER.glob("*.md")}
    return {name: {"page": page, "title": title} for page, title in pages.items() for name in names_of(page)}
