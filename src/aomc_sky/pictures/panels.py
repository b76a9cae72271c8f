"""A whole figure: domes side by side, one colour bar, the title above, the key and the conventions below."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, get_args

import numpy as np

from aomc_sky.emission.notebook import png_bytes
from aomc_sky.errors import UsageError, require_one_of
from aomc_sky.extras import optional_module
from aomc_sky.pictures.dome import (
    EXTRA,
    USUAL_COLOURS,
    VOID_COLOUR,
    ColourChoice,
    Colours,
    Panel,
    View,
    colours_of,
    draw_dome,
    draw_mark,
    plain_label,
    plain_text,
    tick_numbers,
    width_of,
)
from aomc_sky.pictures.picture import MOST_PANELS, Picture, Symbol

ScaleWord = Literal["shared", "each"]
SCALES = get_args(ScaleWord)
"""Colours of several domes: one bar for all, or a bar for each."""

_PROJECTION = "Zenith in the centre, horizon at the rim, the zenith angle as radius."
_MARGIN_IN, _BETWEEN_IN = 0.12, 0.14
_BAR_IN, _BAR_WIDTH = 0.12, 0.86
_OWN_TITLE = 1.2  # of matplotlib's font.size, as its titles are
_FONT, _TITLE, _LINE = 0.8, 1.25, 1.3  # of matplotlib's font.size, of the other letters, of their height
_TITLE_WIDTH = 0.92  # of a dome
_LEAST_TITLE, _SMALL_TITLE = 0.85, 0.6  # of the usual letters, in one line and in a line for each part
_OWN_BAR_IN, _OWN_BAR_WIDTH = 0.07, 0.8  # of a dome
_ROWS = {1: (1,), 2: (2,), 3: (3,), 4: (2, 2), 5: (3, 2), 6: (3, 3), 7: (4, 3), 8: (4, 4), 9: (3, 3, 3), 10: (4, 3, 3)}
_ROWS |= {11: (4, 4, 3), 12: (4, 4, 4)}


def figure_of(
    picture: Picture,
    *,
    size_px: int = 960,
    view: View = View.ABOVE,
    choice: ColourChoice = USUAL_COLOURS,
    scale: ScaleWord = "shared",
    has_caption: bool = True,
) -> Any:
    """Draw a picture of 1 to 12 domes as a Figure with its own canvas and no window system, `size_px` dots wide.

    With the scale "each" every dome has its own colours and bar. Without matplotlib a MissingExtraError names the
    extra.
    """
    require_one_of(SCALES, scale, "scale")
    if not 1 <= len(picture.domes) <= MOST_PANELS:
        raise UsageError(f"a picture has 1 to {MOST_PANELS} domes, got {len(picture.domes)}")
    width_in = width_of(size_px)
    dpi = size_px / width_in
    figure_module = optional_module("matplotlib.figure", extra=EXTRA)
    backend = optional_module("matplotlib.backends.backend_agg", extra=EXTRA)
    is_shared = scale == "shared" or len(picture.domes) == 1
    layout = _Layout.of(picture, width_in, dpi, view, is_shared=is_shared, has_caption=has_caption)
    figure = figure_module.Figure(figsize=(width_in, layout.height_in), dpi=dpi)
    backend.FigureCanvasAgg(figure)
    figure._repr_png_ = partial(png_bytes, figure)  # a notebook shows it
    shared = colours_of(picture, choice)
    mesh = None
    for k, dome in enumerate(picture.domes):
        alone = dataclasses.replace(picture, domes=(dome,))
        colours = shared if is_shared else colours_of(alone, choice)
        axes = figure.add_axes(layout.axes(k), label=f"dome {k + 1}")
        mesh = draw_dome(axes, dome, picture.quantity, colours, layout.panel)
        _draw_dome_title(figure, layout, k)
        if not is_shared and has_colours(alone):
            _draw_bar(figure, layout, mesh, colours, layout.own_bar(k), label=f"colour bar {k + 1}")
    if layout.has_bar and is_shared:
        label = _bar_label(picture, shared)
        _draw_bar(figure, layout, mesh, shared, layout.bar, label="colour bar").set_label(
            label, fontsize=layout.fitting_pt(plain_label(label), 0.0), labelpad=2
        )
    elif layout.has_bar:
        at = 0.5, (layout.caption_in + layout.key_in + 0.06) / layout.height_in
        label = _bar_label(picture, shared)
        font = layout.fitting_pt(plain_label(label), 0.0)
        figure.text(*at, label, ha="center", va="bottom", fontsize=font)
    _draw_texts(figure, layout)
    _draw_key(figure, layout)
    return figure


def _bar_label(picture: Picture, colours: Colours) -> str:
    """Quantity and unit, and whether the bar is logarithmic."""
    return picture.quantity.label + (", log scale" if type(colours.norm).__name__ == "LogNorm" else "")


def _letters_pt() -> float:
    """Size of letters that the reader of a figure has chosen. [pt]"""
    return float(optional_module("matplotlib", extra=EXTRA).rcParams["font.size"])


def draw_into(axes: Any, picture: Picture, *, view: View, choice: ColourChoice, scale: ScaleWord = "shared") -> Any:
    """Draw the domes of a picture into axes that somebody has, one for each; their figure is returned."""
    require_one_of(SCALES, scale, "scale")
    every = np.atleast_1d(np.asarray(axes, dtype=object)).ravel().tolist()
    if len(every) != len(picture.domes):
        raise UsageError(f"{len(picture.domes)} domes need as many axes, got {len(every)}; bands chooses wavebands")
    shared = colours_of(picture, choice)
    _lay_out(every[0].get_figure())
    for one, dome in zip(every, picture.domes, strict=True):
        box, dpi = one.get_window_extent(), one.get_figure().dpi
        panel = Panel(width_in=box.width / dpi, font_pt=_letters_pt(), view=view)
        if panel.height_in > box.height / dpi:  # lower than wide
            width = box.height / dpi + panel.width_in - panel.height_in
            panel = dataclasses.replace(panel, width_in=width)
        alone = dataclasses.replace(picture, domes=(dome,))
        draw_dome(one, dome, picture.quantity, shared if scale == "shared" else colours_of(alone, choice), panel)
        one.set_aspect("equal")
        title = plain_text(picture.title if len(every) == 1 and picture.title else dome.title)
        ruler, font = Ruler.of(dpi), _OWN_TITLE * _letters_pt()
        lines = [
            line for text in title.split("\n") if text for line in _fitting_lines(text, font, box.width / dpi, ruler)
        ]
        one.set_title("\n".join(line for line, _ in lines), fontsize=min((pt for _, pt in lines), default=None))
    _lay_out(every[0].get_figure())
    return every[0].get_figure()


def _lay_out(figure: Any) -> None:
    """Let the layout of a figure, if it has one, place the axes: domes and titles are measured by them.

    Each time the layout takes the room of titles above square axes from where they were the time before.
    """
    for _ in range(2 if figure.get_layout_engine() is not None else 0):
        figure.draw_without_rendering()


@dataclass(frozen=True, kw_only=True, slots=True)
class _Layout:
    """Positions of all parts, in inches from the lower left corner; rows count from the top."""

    width_in: float
    panel: Panel
    rows: tuple[int, ...]
    title: str
    title_in: float
    titles: tuple[list[tuple[str, float]], ...]
    has_bar: bool
    is_shared: bool
    caption: str
    caption_in: float
    keys: tuple[Symbol | str, ...]
    font_pt: float
    ruler: Ruler

    @classmethod
    def of(
        cls, picture: Picture, width_in: float, dpi: float, view: View, *, is_shared: bool, has_caption: bool
    ) -> _Layout:
        """Lay the parts of a picture out."""
        font, rows = _FONT * _letters_pt(), _ROWS[len(picture.domes)]
        inside = width_in - 2 * _MARGIN_IN
        most_in = 0.98 * inside  # letters of .svg and .pdf, which no dots move, may be a little wider
        width = (inside - (rows[0] - 1) * _BETWEEN_IN) / rows[0]
        panel = Panel(width_in=width, font_pt=font if rows[0] < 3 else 0.9 * font, view=view)
        ruler = Ruler.of(dpi)
        title = _wrapped(picture.title, _TITLE * font, most_in, ruler)
        sentences = (view.sentence, _PROJECTION, *picture.sun_sentence, *picture.notes) if has_caption else ()
        caption = _wrapped(" ".join(sentences), font, most_in, ruler)
        line = _LINE * font / 72
        return cls(
            width_in=width_in,
            panel=panel,
            rows=rows,
            title=title,
            title_in=line * (_TITLE * _n_lines(title) + 0.8) if title else 0.05,
            titles=tuple(_title_lines(dome.title, panel, ruler) for dome in picture.domes),
            has_bar=has_colours(picture),
            is_shared=is_shared,
            caption=caption,
            caption_in=line * (_n_lines(caption) + 0.6),
            keys=keys_of(picture),
            font_pt=font,
            ruler=ruler,
        )

    def fitting_pt(self, line: str, indent_in: float) -> float:
        """Size of the letters of a line that must not be broken: smaller where it would leave the figure."""
        most_in = self.width_in - 2 * _MARGIN_IN - indent_in
        return self.font_pt * min(1.0, most_in / self.ruler.width_in(line, self.font_pt))

    @property
    def title_line_in(self) -> float:
        """Height of a line of the title of a dome."""
        return _LINE * (self.panel.font_pt + 1.0) / 72

    @property
    def row_in(self) -> float:
        """Height of a row of domes with their titles, and their bars where each has its own."""
        bars = 0.0 if self.is_shared or not self.has_bar else _OWN_BAR_IN + 2.6 * self.panel.font_pt / 72
        return self.panel.height_in + max(map(len, self.titles)) * self.title_line_in + bars

    @property
    def key_in(self) -> float:
        """Height of the key."""
        return 1.15 * _LINE * self.font_pt / 72 * len(self.keys)

    @property
    def bar_in(self) -> float:
        """Height of the colour bar with its numbers and its label, or of the label alone."""
        letters = (_BAR_IN + 4.6 * self.font_pt / 72) if self.is_shared else 2.2 * self.font_pt / 72
        return letters if self.has_bar else 0.0

    @property
    def bar(self) -> tuple[float, float, float, float]:
        """Left, lower edge, width and height of the bar that all domes share. [inch]"""
        length = _BAR_WIDTH * self.width_in
        bottom = self.caption_in + self.key_in + self.bar_in - _BAR_IN - 0.06
        return (self.width_in - length) / 2, bottom, length, _BAR_IN

    def own_bar(self, k: int) -> tuple[float, float, float, float]:
        """The same of the bar of one dome."""
        x, y = self.corner(k)
        length = _OWN_BAR_WIDTH * self.panel.width_in
        return x + (self.panel.width_in - length) / 2, y - _OWN_BAR_IN - 0.04, length, _OWN_BAR_IN

    @property
    def height_in(self) -> float:
        """Height of the figure."""
        return self.title_in + len(self.rows) * self.row_in + self.bar_in + self.key_in + self.caption_in

    def axes(self, k: int) -> tuple[float, float, float, float]:
        """The axes of a dome in parts of the figure."""
        return self.parts(*self.corner(k), self.panel.width_in, self.panel.height_in)

    def corner(self, k: int) -> tuple[float, float]:
        """Lower left corner of the axes of a dome; a row with fewer domes is centred."""
        row = int(np.searchsorted(np.cumsum(self.rows), k, side="right"))
        step = self.panel.width_in + _BETWEEN_IN
        left = (self.width_in - self.rows[row] * step + _BETWEEN_IN) / 2
        titles_in = max(map(len, self.titles)) * self.title_line_in
        top = self.height_in - self.title_in - row * self.row_in - titles_in
        return left + (k - sum(self.rows[:row])) * step, top - self.panel.height_in

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


def _title_lines(title: str, panel: Panel, ruler: Ruler) -> list[tuple[str, float]]:
    """Lines of the title of a dome that are narrower than the dome, and the size of their letters: smaller below."""
    first, _, rest = plain_text(title).partition("\n")
    parts = (first, panel.font_pt + 1.0), (rest, panel.font_pt)
    most_in = _TITLE_WIDTH * panel.width_in
    return [one for text, font in parts if text for one in _fitting_lines(text, font, most_in, ruler)]


def _fitting_lines(text: str, font_pt: float, width_in: float, ruler: Ruler) -> list[tuple[str, float]]:
    """A text in one line with letters as they are or a little smaller, or else in several: one for each comma."""
    part = width_in / ruler.width_in(text, font_pt)
    if part >= _LEAST_TITLE:
        return [(text, font_pt * min(1.0, part))]
    parts = text.split(", ")
    for pieces, least in (
        (parts, _SMALL_TITLE),
        (text.split(), 0.0),
    ):  # lines that are whole parts, or else whole words
        font = font_pt
        while max(ruler.width_in(piece, font) for piece in pieces) > width_in:
            font *= 0.97
        if font >= least * font_pt:
            break
    return [(line, font) for part in parts for line in ruler.even_lines(part, font, width_in)]


def _draw_bar(
    figure: Any, layout: _Layout, mesh: Any, colours: Colours, box: tuple[float, float, float, float], *, label: str
) -> Any:
    """A colour bar with its numbers, in a box in inches."""
    axes = figure.add_axes(layout.parts(*box), label=label)
    style = {"orientation": "horizontal", "extend": colours.extend, "extendfrac": 0.025}
    bar = figure.colorbar(mesh, cax=axes, **style)
    width_in = (4.5 if layout.is_shared else 3.2) * layout.font_pt / 72  # of a number
    tick_numbers(bar, colours, most=int(box[2] / width_in))
    bar.minorticks_off()
    bar.ax.tick_params(labelsize=0.9 * layout.panel.font_pt, pad=2)
    return bar


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
    mark_pt = 0.8 * layout.font_pt  # lower than a line
    centre, left = layout.font_pt / 72, 2.2 * layout.font_pt / 72
    for k, key in enumerate(reversed(keys)):
        if isinstance(key, Symbol):
            draw_mark(axes, centre, k + 0.5, key, mark_pt)
        else:
            style = {"marker": "s", "markersize": mark_pt, "markeredgecolor": "#888888", "linestyle": "none"}
            axes.plot([centre], [k + 0.5], markerfacecolor=VOID_COLOUR, markeredgewidth=0.6, **style)
        text = key.value if isinstance(key, Symbol) else key
        axes.text(left, k + 0.5, text, ha="left", va="center", fontsize=layout.fitting_pt(text, left))


@dataclass(frozen=True, slots=True)
class Ruler:
    """Measures text in matplotlib's font, whose letters start at whole dots and so are wider on few dots."""

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
        """Break a paragraph into lines between its words, and within words that are too long."""
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
