r"""Equations as MathML, which browsers show without a script, a font or a network.

A number is what ``\tag{...}`` says; it stands at the right margin.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert

_TAG = re.compile(r"\\tag\{([^}]*)\}")
_FUNCTION = r"<mi>(?:arctan|cos|cot|exp|ln|log|sin|sinh|tan)</mi>"
_BEFORE = re.compile(rf"(</mi>)(?={_FUNCTION})")
_BEHIND = re.compile(rf"({_FUNCTION})(?=<m(?:i|sub)>)")
_SPACE = r'\1<mspace width="0.17em"/>'


def _mathml(latex: str, display: str) -> str:
    """Return MathML, with the spaces of printed formulas around functions."""
    return _BEHIND.sub(_SPACE, _BEFORE.sub(_SPACE, convert(latex, display=display)))


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    latex = node.astext()
    tag = _TAG.search(latex)
    writer.body.append(writer.starttag(node, "div", CLASS="equation"))
    writer.body.append(f'<div class="formula">{_mathml(_TAG.sub("", latex).strip(), "block")}</div>')
    if tag is not None:
        writer.body.append(f'<span class="number">({tag[1]})</span>')
    writer.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Register the renderer; `html_math_renderer = "mathml"` takes it."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
