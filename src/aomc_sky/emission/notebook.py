"""A table in a notebook, with the dome of the sky if matplotlib is installed."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Sequence
from html import escape
from typing import Any

from aomc_sky.errors import AomcSkyError, MissingExtraError

MOST_ROWS = 12
"""Wavebands or photons that a table shows."""


def html(
    title: str, head: Sequence[str], rows: Sequence[Sequence[object]], n_rows: int, draw: Callable[[], Any]
) -> str:
    """A title, a table with the first of `n_rows` rows, and the figure that `draw` gives."""
    cells = ["".join(f"<th>{escape(name)}</th>" for name in head)]
    cells += ["".join(f"<td>{escape(str(value))}</td>" for value in row) for row in rows]
    if n_rows > len(rows):
        cells.append(f"<td>... {n_rows} in all</td>")
    table = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<p><b>{escape(title)}</b></p><table>{table}</table>{_picture(draw)}"


def _picture(draw: Callable[[], Any]) -> str:
    try:
        data = png_bytes(draw())
    except MissingExtraError as error:
        return f"<p>{escape(str(error))}</p>"
    except AomcSkyError:  # a scene without light has no dome
        return ""
    return f'<img alt="the dome of the sky" src="data:image/png;base64,{base64.b64encode(data).decode()}">'


def png_bytes(figure: Any) -> bytes:
    """A figure of matplotlib as a PNG."""
    data = io.BytesIO()
    figure.canvas.print_png(data)  # savefig draws twice
    return data.getvalue()
