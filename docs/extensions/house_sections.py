"""Docstrings of the house as pages: its sections Accuracy and Cost, and its sources in brackets."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

from topics import topic_of

# numpydoc also reads signatures, from the docstrings as they stand
warnings.filterwarnings("ignore", message="Unknown section (Accuracy|Cost)", category=UserWarning)

_OWN_SECTIONS = ("Accuracy", "Cost")
_NAMES = topic_of()
_BEGINNING = "They begin with ``import numpy as np`` and ``import aomc_sky as sky``."
_SOURCES = "|".join(
    re.findall(r"^@\w+\{(\w+),", (Path(__file__).parents[1] / "references.bib").read_text(), re.MULTILINE)
)


def _link(match: re.Match[str], room: str) -> str:
    """A public name in quotes as a link to its page, seen from `room`."""
    full = next((full for full in (f"aomc_sky.{match[1]}", f"{room}.{match[1]}", match[1]) if full in _NAMES), None)
    return match[0] if full is None else f":py:obj:`{match[1]} <{full}>`"


def _house_sections(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Turn sections Accuracy and Cost into notes, bars of absolute values into text, and sources into links.

    Examples say what they import, and public names in quotes lead to their pages.
    """
    kept: list[str] = []
    notes: list[str] = []
    target = kept
    for k, line in enumerate(lines):
        underlined = k + 1 < len(lines) and re.fullmatch(r"-{3,}", lines[k + 1].strip()) is not None
        if underlined and line.strip() in _OWN_SECTIONS:
            target = notes
            notes += ["", f"**{line.strip()}.**"]
        elif underlined:
            target = kept
            kept.append(line)
        elif not (target is notes and re.fullmatch(r"-{3,}", line.strip())):
            target.append(line)
    if notes:
        start = next((k + 2 for k, line in enumerate(kept) if line.strip() == "Notes"), None)
        if start is None:
            start = len(kept) + 3
            kept += ["", "Notes", "-----"]
        kept[start:start] = [*notes, ""]
    for k, line in enumerate(kept):
        if line.strip() == "Examples" and k + 1 < len(kept) and set(kept[k + 1].strip()) == {"-"}:
            kept[k + 2 : k + 2] = [_BEGINNING, ""]
            break
    kept = [re.sub(r"(?<![`|])\|(\S[^|`]*)\|", r"\\|\1\\|", line) for line in kept]
    kept = [re.sub(rf"\[({_SOURCES})\]", r":cite:`\1`", line) for line in kept]
    room = name.rpartition(".")[0]
    lines[:] = [re.sub(r"(?<![`:\w])`([\w.]+)`(?!`)", lambda match: _link(match, room), line) for line in kept]


def setup(app: Any) -> dict[str, bool]:
    """Run before numpydoc reads the docstrings."""
    app.connect("autodoc-process-docstring", _house_sections, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
