"""Tables of the pages: cells of a few letters do not break, and options come from the table of options.

A wide table scrolls instead of cutting its numbers. `{keys} sun` makes the table of [sun] of sky.toml, `{options} plot`
that of the options that `plot` has for itself, `{options} READING` that of the groups `aomc_sky.cli.options.READING`
with the commands that have them, and `{names} scene` lists the names of docs/api/scene.md.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from option_tables import keys_table, options_table
from sphinx.util.docutils import SphinxDirective
from topics import names_of

from aomc_sky.options import SECTIONS

_SHORT = 12


class _Keys(SphinxDirective):
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        return list(self.parse_text_to_nodes(keys_table(SECTIONS[self.arguments[0]])))


class _Options(SphinxDirective):
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        return list(self.parse_text_to_nodes(options_table(self.arguments[0])))


class _Names(SphinxDirective):
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        links = []
        for name in names_of(self.arguments[0]):
            public = re.fullmatch(r"aomc_sky\.((?:[a-z_]+\.)?\w+)", name)  # a class that is only returned stands deeper
            links.append(f"{{py:obj}}`{public[1] if public else name.rpartition('.')[2]} <{name}>`")
        return list(self.parse_text_to_nodes(" · ".join(links)))


def _mark_short_cells(app: Any, doctree: nodes.document, docname: str) -> None:
    for cell in doctree.findall(nodes.entry):
        if len(cell.astext()) <= _SHORT:
            cell["classes"].append("short")


def setup(app: Any) -> dict[str, bool]:
    """Know the directives, and mark cells when a page is ready."""
    app.add_directive("keys", _Keys)
    app.add_directive("options", _Options)
    app.add_directive("names", _Names)
    app.connect("doctree-resolved", _mark_short_cells)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
