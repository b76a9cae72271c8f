"""Cells of a few letters do not break, so that a wide table scrolls instead of cutting its numbers."""

from __future__ import annotations

from typing import Any

from docutils import nodes

_SHORT = 12


def _mark_short_cells(app: Any, doctree: nodes.document, docname: str) -> None:
    for cell in doctree.findall(nodes.entry):
        if len(cell.astext()) <= _SHORT:
            cell["classes"].append("short")


def setup(app: Any) -> dict[str, bool]:
    """Mark cells when a page is ready."""
    app.connect("doctree-resolved", _mark_short_cells)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
