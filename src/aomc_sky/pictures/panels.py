"""A whole figure: domes side by side, one colour bar, the title above, the key and the conventions below."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.pictures.content import MOST_PANELS, Picture, Symbol
from aomc_sky.pictures.dome import (
    EXTRA,
    VOID_COLOUR,
    Colours,
    Panel,
    Scale,
    View,
    colours_of,
    draw_dome,
    draw_mark,
    plain_text,
    tick_numbers,
)

_PROJECTION = "Zenith in the centre, horizon at the rim, the zenith angle as radius."
_MARGIN_IN = 0.12
_BAR_IN, _BAR_WIDTH = 0.12, 0.86
_FONT_PT, _TITLE, _LINE = 8.0, 1.25, 1.3
_TITLE_WIDTH = 0.92  # of a dome
_SHRINKS = (1.0, 0.95, 0.9, 0.85, 0.8)  # in steps: the widths of small letters are whole dots, and do not follow


def figure_of(
    picture: Picture,
    *,
    size_px: int = 960,
    view: View = View.ABOVE,
    like: Picture | None = None,
    limits: Sequence[float] | None = None,
) -> Any:
    """Draw a picture of 1 to 12 domes as a Figure with its own canvas and no window system, `size_px` dots wide.

    The colours and the key serve all domes of `like` where it is given, so that frames of an animation are alike.
    Without matplotlib a MissingExtraError names the extra.
    """
    if not 1 <= len(picture.domes) <= MOST_PANELS:
        raise UsageError(f"a picture has 1 to {MOST_PANELS} domes, got {len(picture.domes)}")
    scale = Scale.of(size_px)
    figure_module = optional_module("matplotlib.figure", extra=EXTRA)
    backend = optional_module("matplotlib.backends.backend_agg", extra=EXTRA)
    like = like or picture
    colours = colours_of(like, limits)
    layout = _Layout.of(picture, like, scale, view)
    figure = figure_module.Figure(figsize=(scale.width_in, layout.height_in), dpi=scale.dpi, facecolor="white")
    backend.FigureCanvasAgg(figure)
    mesh = None
    for k, dome in enumerate(picture.domes):
        axes = figure.add_axes(layout.axes(k), label=f"dome {k + 1}")
        mesh = draw_dome(axes, dome, picture.quantity, colours, layout.panel)
        _draw_dome_title(figure, layout, k)
    if layout.has_bar:
        _draw_bar(figure, layout, mesh, colours, picture.quantity.label)
    _draw_texts(figure, layout)
    _draw_key(figure, layout)
    return figure


@dataclass(frozen=True, kw_only=True, slots=True)
class _Layout:
    """Places of everything, in inches from the lower left corner; heights are those of rows, from the top down."""

    width_in: float
    panel: Panel
    n_columns: int
    n_rows: int
    title: str
    title_in: float
    titles: tuple[list[tuple[str, float]], ...]
    has_bar: bool
    caption: str
    caption_in: float
    keys: tuple[Symbol | str, ...]
    font_pt: float

    @classmethod
    def of(cls, picture: Picture, like: Picture, scale: Scale, view: View) -> _Layout:
        """Lay the parts of a picture out."""
        n, font = len(picture.domes), _FONT_PT
        columns = 1 if n == 1 else 2 if n in (2, 4) else 3 if n <= 9 else 4
        inside = scale.width_in - 2 * _MARGIN_IN
        most_in = 0.98 * inside  # letters of .svg and .pdf, which no dots move, may be a little wider
        panel = Panel(width_in=inside / columns, font_pt=font if columns < 3 else 0.9 * font, view=view)
        ruler = Ruler.of(scale.dpi)
        shrink = _title_shrink(picture, panel, ruler)
        title = _wrapped(picture.title, _TITLE * font, most_in, ruler)
        caption = _wrapped(" ".join((view.sentence, _PROJECTION, *picture.notes)), font, most_in, ruler)
        line = _LINE * font / 72
        return cls(
            width_in=scale.width_in,
            panel=panel,
            n_columns=columns,
            n_rows=math.ceil(n / columns),
            title=title,
            title_in=line * (_TITLE * _n_lines(title) + 0.8) if title else 0.05,
            titles=tuple(_title_lines(dome.title, panel, shrink, ruler) for dome in picture.domes),
            has_bar=has_colours(like),
            caption=caption,
            caption_in=line * (_n_lines(caption) + 0.6),
            keys=keys_of(like),
            font_pt=font,
        )

    @property
    def title_line_in(self) -> float:
        """Height of a line of the title of a dome."""
        return _LINE * (self.panel.font_pt + 1.0) / 72

    @property
    def row_in(self) -> float:
        """Height of a row of domes with their titles."""
        return self.panel.height_in + max(map(len, self.titles)) * self.title_line_in

    @property
    def key_in(self) -> float:
        """Height of the key."""
        return 1.15 * _LINE * self.font_pt / 72 * len(self.keys)

    @property
    def bar_in(self) -> float:
        """Height of the colour bar with its numbers and its label."""
        return _BAR_IN + 4.6 * self.font_pt / 72 if self.has_bar else 0.0

    @property
    def height_in(self) -> float:
        """Height of the figure."""
        return self.title_in + self.n_rows * self.row_in + self.bar_in + self.key_in + self.caption_in

    def axes(self, k: int) -> tuple[float, float, float, float]:
        """The axes of a dome in parts of the figure."""
        return self.parts(*self.corner(k), self.panel.width_in, self.panel.height_in)

    def corner(self, k: int) -> tuple[float, float]:
        """Lower left corner of the axes of a dome."""
        row, column = divmod(k, self.n_columns)
        return _MARGIN_IN + column * self.panel.width_in, self.height_in - self.title_in - (row + 1) * self.row_in

    def parts(self, x: float, y: float, width: float, height: float) -> tuple[float, float, float, float]:
        """Inches as parts of the figure."""
        return x / self.width_in, y / self.height_in, width / self.width_in, height / self.height_in


def _n_lines(text: str) -> int:
    return text.count("\n") + 1 if text else 0


def _wrapped(text: str, font_pt: float, width_in: float, ruler: Ruler) -> str:
    return "\n".join("\n".join(ruler.lines(line, font_pt, width_in)) for line in plain_text(text).split("\n"))


def keys_of(picture: Picture) -> tuple[Symbol | str, ...]:
    """Lines of the key: the symbols that occur, and what patches without a colour are."""
    present = {mark.symbol for dome in picture.domes for mark in dome.marks}
    keys: list[Symbol | str] = [symbol for symbol in Symbol if symbol in present]
    if not all(dome.is_hemisphere and np.all(dome.has_colour(picture.quantity)) for dome in picture.domes):
        keys.append(picture.quantity.void)
    return tuple(keys)


def has_colours(picture: Picture) -> bool:
    """Whether any patch has a colour."""
    return any(bool(np.any(dome.has_colour(picture.quantity))) for dome in picture.domes)


def _draw_dome_title(figure: Any, layout: _Layout, k: int) -> None:
    x, y = layout.corner(k)
    x, y = x + layout.panel.width_in / 2, y + layout.panel.height_in
    for line, (text, font) in enumerate(reversed(layout.titles[k])):
        height = y + line * layout.title_line_in
        figure.text(x / layout.width_in, height / layout.height_in, text, ha="center", va="bottom", fontsize=font)


def _title_shrink(picture: Picture, panel: Panel, ruler: Ruler) -> float:
    """How much smaller the titles of all domes are set, so that each line is narrower than its dome; else 1."""
    lines = [line for dome in picture.domes for line in _title_parts(dome.title, panel)]
    most_in = _TITLE_WIDTH * panel.width_in
    fitting = (s for s in _SHRINKS if all(ruler.width_in(text, s * font) <= most_in for text, font in lines))
    return next(fitting, 1.0)


def _title_lines(title: str, panel: Panel, shrink: float, ruler: Ruler) -> list[tuple[str, float]]:
    """Lines of the title of a dome that are as wide as the dome at most, and the size of their letters."""
    parts = [(text, shrink * font) for text, font in _title_parts(title, panel)]
    return [(line, font) for text, font in parts for line in ruler.even_lines(text, font, panel.width_in)]


def _title_parts(title: str, panel: Panel) -> tuple[tuple[str, float], tuple[str, float]]:
    """The first line, and what is smaller below it."""
    first, _, rest = plain_text(title).partition("\n")
    return (first, panel.font_pt + 1.0), (rest, panel.font_pt)


def _draw_bar(figure: Any, layout: _Layout, mesh: Any, colours: Colours, label: str) -> None:
    bottom = layout.caption_in + layout.key_in + layout.bar_in - _BAR_IN - 0.06
    length = _BAR_WIDTH * layout.width_in
    box = layout.parts((layout.width_in - length) / 2, bottom, length, _BAR_IN)
    bar = figure.colorbar(
        mesh,
        cax=figure.add_axes(box, label="colour bar"),
        orientation="horizontal",
        extend=colours.extend,
        extendfrac=0.025,
    )
    tick_numbers(bar, colours, most=int(length * 72 / (4.5 * layout.font_pt)))
    bar.minorticks_off()
    bar.ax.tick_params(labelsize=0.9 * layout.font_pt, pad=2)
    bar.set_label(label, fontsize=layout.font_pt, labelpad=2)


def _draw_texts(figure: Any, layout: _Layout) -> None:
    font = layout.font_pt
    if layout.title:
        top = 1 - 0.4 * font / 72 / layout.height_in
        figure.text(0.5, top, layout.title, ha="center", va="top", fontsize=_TITLE * font)
    position = _MARGIN_IN / layout.width_in, 0.5 * font / 72 / layout.height_in
    figure.text(*position, layout.caption, ha="left", va="bottom", fontsize=font, linespacing=_LINE)


def _draw_key(figure: Any, layout: _Layout) -> None:
    keys = layout.keys
    if not keys:
        return
    width = layout.width_in - 2 * _MARGIN_IN
    axes = figure.add_axes(layout.parts(_MARGIN_IN, layout.caption_in, width, layout.key_in), label="key")
    axes.set_axis_off()
    axes.set_xlim(0, width)
    axes.set_ylim(0, len(keys))
    for k, key in enumerate(reversed(keys)):
        if isinstance(key, Symbol):
            draw_mark(axes, 0.1, k + 0.5, key, layout.font_pt)
        else:
            style = {"marker": "s", "markersize": layout.font_pt, "markeredgecolor": "#888888", "linestyle": "none"}
            axes.plot([0.1], [k + 0.5], markerfacecolor=VOID_COLOUR, markeredgewidth=0.6, **style)
        text = key.value if isinstance(key, Symbol) else key
        axes.text(0.25, k + 0.5, text, ha="left", va="center", fontsize=layout.font_pt)


@dataclass(frozen=True, slots=True)
class Ruler:
    """Measures text in matplotlib's own font, whose letters are moved to whole dots: few dots make it wider."""

    #: What would draw it.
    renderer: Any

    @classmethod
    def of(cls, dpi: float) -> Ruler:
        """A ruler for a picture of so many dots per inch."""
        return cls(optional_module("matplotlib.backends.backend_agg", extra=EXTRA).RendererAgg(1, 1, dpi))

    def width_in(self, line: str, font_pt: float) -> float:
        """Width of a line. [inch]"""
        properties = optional_module("matplotlib.font_manager", extra=EXTRA).FontProperties(size=font_pt)
        width = self.renderer.get_text_width_height_descent(line, properties, ismath=False)[0]
        return float(width) / float(self.renderer.dpi)

    def lines(self, text: str, font_pt: float, width_in: float) -> list[str]:
        """Break a paragraph into lines between its words, and within words that are too long; at least a letter in
        each.
        """
        lines: list[str] = []
        for word in text.split():
            longer = f"{lines[-1]} {word}" if lines else word
            if lines and self.width_in(longer, font_pt) <= width_in:
                lines[-1] = longer
                continue
            lines.append("")
            for letter in word:
                if lines[-1] and self.width_in(lines[-1] + letter, font_pt) > width_in:
                    lines.append("")
                lines[-1] += letter
        return lines

    def even_lines(self, text: str, font_pt: float, width_in: float) -> list[str]:
        """As few lines as `lines` has, the widest of them as narrow as can be."""
        lines = self.lines(text, font_pt, width_in)
        while len(lines) > 1:
            widest = max(self.width_in(line, font_pt) for line in lines)
            narrower = self.lines(text, font_pt, 0.999 * widest)
            if len(narrower) > len(lines) or narrower == lines:
                break
            lines = narrower
        return lines
