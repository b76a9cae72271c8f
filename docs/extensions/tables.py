"""Tables of the pages: cells of a few letters do not break, and the inputs of sky and sun come from their own rows.

A wide table scrolls instead of cutting its numbers. `{inputs} SUN` makes the table of `aomc_sky.inputs.SUN`, and
`{names} scene` lists the names of docs/api/scene.md.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective
from topics import names_of

from aomc_sky import inputs
from aomc_sky.formats.sky_toml.keys import range_text

_SHORT = 12


def inputs_table(rows: Mapping[str, inputs.Input]) -> str:
    """Keys of sky.toml in Markdown: what each is, its range or words, its option."""
    lines = ["| key | meaning | range | option |", "| --- | --- | --- | --- |"]
    for name, row in rows.items():
        key, text = f"`{name}`", row.text
        if name == "coefficients":
            key, text = "`a` to `e`", f"{name} {text}"
        words = ("true", "false") if row.is_switch else [f'"{word}"' for word in row.words]
        bounds = range_text(row.low, row.high).replace("e+0", "e").replace("e+", "e")
        values = ", ".join(f"`{word}`" for word in words) or bounds
        unit = f" [{row.unit}]" if row.unit else ""
        lines.append(f"| {key} | {text.replace('--', chr(92) + '--')}{unit} | {values} | `{row.option}` |")
    return "\n".join(lines)


class _Inputs(SphinxDirective):
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        return list(self.parse_text_to_nodes(inputs_table(getattr(inputs, self.arguments[0]))))


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
    app.add_directive("inputs", _Inputs)
    app.add_directive("names", _Names)
    app.connect("doctree-resolved", _mark_short_cells)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
