"""A whole figure: domes side by side, one colour bar, the title above, the key and the conventions below."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any, Literal, get_args

import numpy as np

from aomc_sky.emission.notebook import png_bytes
from aomc_sky.errors import UsageError, require_one_of
from aomc_sky.extras import optional_module
from aomc_sky.pictures.dome import (
    EXTRA,
    USUAL_COLOURS,
    ColourChoice,
    Colours,
    Panel,
    View,
    colours_of,
    draw_dome,
    mark_styles,
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
_PAD_IN = 0.07
_TALL_IN = 40.0  # a page on which every text has room, before the height is known
_BAR, _OWN_BAR = (0.86, 0.12, 4.2), (0.8, 0.07, 3.2)
"""Of a bar its length in parts of the domes above it, its height in inches, and the room for a number in letters."""
_FONT, _TITLE, _LINE = 0.8, 1.25, 1.3  # of matplotlib's font.size, of the other letters, of their height
_OWN_TITLE = 1.2  # of matplotlib's font.size, as its titles are
_TITLE_WIDTH = 0.92  # of a dome
_LEAST_TITLE, _LEAST_PART, _SMALLEST = 0.85, 0.6, 0.5  # of the usual letters: in one line, in more, of long words


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
    extra. The constrained layout of matplotlib places everything; the height follows from it.
    """
    require_one_of(SCALES, scale, "scale")
    if not 1 <= len(picture.domes) <= MOST_PANELS:
        raise UsageError(f"a picture has 1 to {MOST_PANELS} domes, got {len(picture.domes)}")
    figure, font, rows = _page(size_px), _FONT * _letters_pt(), _rows_of(len(picture.domes))
    width_in, ruler = figure.get_figwidth(), Ruler(figure.dpi)
    inside_in = 0.98 * (width_in - 2 * _PAD_IN)  # letters of .svg and .pdf, which no dots move, may be a little wider
    sentences = (view.sentence, _PROJECTION, *picture.sun_sentence, *picture.notes) if has_caption else ()
    caption = ruler.wrapped(" ".join(sentences), font, inside_in)
    figure.supxlabel(caption, x=_PAD_IN / width_in, ha="left", fontsize=font, linespacing=_LINE)
    with_key = figure.subfigures()  # each figure in a figure has its own texts below the domes
    _draw_key(with_key, picture, font, inside_in, ruler)
    with_domes = with_key.subfigures()
    with_domes.suptitle(ruler.wrapped(picture.title, _TITLE * font, inside_in), fontsize=_TITLE * font)
    panel_pt = font if rows[0] < 3 else 0.9 * font
    panel = Panel(width_in=width_in / rows[0] - 2 * _PAD_IN, font_pt=panel_pt, view=view, top_em=1.6)
    is_shared, shared = scale == "shared" or len(picture.domes) == 1, colours_of(picture, choice)
    stacks = []  # a dome and its own bar
    for k, (one, dome) in enumerate(zip(_axes_in_rows(with_domes, rows), picture.domes, strict=True), start=1):
        alone = dataclasses.replace(picture, domes=(dome,))
        colours = shared if is_shared else colours_of(alone, choice)
        mesh = draw_dome(one, dome, picture.quantity, colours, panel)
        for artist in one.get_children():
            artist.set_in_layout(False)  # the axes have room for them
        title_in = _TITLE_WIDTH * panel.width_in
        _draw_title(one, dome.title, panel_pt + 1.0, title_in, ruler, _LEAST_TITLE, y=1.0, pad=0.0)
        stacks.append([one])
        if not is_shared and has_colours(alone):
            stacks[-1].append(_draw_bar(mesh, [one], colours, panel.width_in, font, _OWN_BAR, f"colour bar {k}").ax)
    label = picture.quantity.label + (", log scale" if type(shared.norm).__name__ == "LogNorm" else "")
    label_pt = ruler.fitting_pt(plain_label(label), font, inside_in)
    if has_colours(picture) and is_shared:
        corners = [stacks[k][0] for k in sorted({0, rows[0] - 1, len(stacks) - 1})]  # the layout asks each for its bars
        bar = _draw_bar(mesh, corners, shared, inside_in, font, _BAR, "colour bar")
        bar.set_label(label, fontsize=label_pt, labelpad=2)
    elif has_colours(picture):
        with_domes.supxlabel(label, fontsize=label_pt)
    _place(figure, stacks, rows, panel)
    return figure


def _page(size_px: int) -> Any:
    """A figure so many dots wide, with its own canvas and a layout."""
    width_in = width_of(size_px)
    figure = optional_module("matplotlib.figure", extra=EXTRA).Figure(
        figsize=(width_in, _TALL_IN), dpi=size_px / width_in, layout="constrained"
    )
    optional_module("matplotlib.backends.backend_agg", extra=EXTRA).FigureCanvasAgg(figure)
    figure._repr_png_ = partial(png_bytes, figure)  # a notebook shows it
    figure.get_layout_engine().set(w_pad=_PAD_IN, h_pad=_PAD_IN, wspace=0.0, hspace=0.0)
    return figure


def _axes_in_rows(figure: Any, rows: tuple[int, ...]) -> list[Any]:
    grid = figure.add_gridspec(len(rows), rows[0])
    places = [grid[row, column] for row, n in enumerate(rows) for column in range(n)]
    return [figure.add_subplot(place, label=f"dome {k}") for k, place in enumerate(places, start=1)]


def _place(figure: Any, stacks: list[list[Any]], rows: tuple[int, ...], panel: Panel) -> None:
    """Lay the figure out, make it as high as its domes need, and move rows with fewer of them to the middle.

    The layout before matplotlib 3.11 cannot centre rows of axes in a figure within a figure.
    """
    axes, layout = [stack[0] for stack in stacks], figure.get_layout_engine()
    layout.execute(figure)
    box = axes[0].get_window_extent()  # wide numbers of its bar may have made it narrower than the panel
    too_high_in = (box.height - box.width * panel.height_in / panel.width_in) / figure.dpi
    figure.set_figheight(_TALL_IN - len(rows) * too_high_in)
    layout.execute(figure)
    figure.set_layout_engine("none")
    boxes = [one.get_position(original=True) for one in axes]
    for row, n in enumerate(rows):
        first = sum(rows[:row])
        ends = boxes[0].x0, boxes[rows[0] - 1].x1, -boxes[first].x0, -boxes[first + n - 1].x1
        for one in (one for stack in stacks[first : first + n] for one in stack):
            one.set_position(one.get_position(original=True).translated(sum(ends) / 2, 0.0))
    for one in axes:
        one.set_aspect("equal")  # the second time bars may differ by a dot


def _rows_of(n_domes: int) -> tuple[int, ...]:
    """Domes of each row, as even as can be, the longer rows first."""
    n_rows = 1 + (n_domes > 3) + (n_domes > 8)
    return tuple((n_domes + n_rows - 1 - row) // n_rows for row in range(n_rows))


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
        title = picture.title if len(every) == 1 and picture.title else dome.title
        _draw_title(one, title, _OWN_TITLE * _letters_pt(), box.width / dpi, Ruler(dpi), _LEAST_PART)
    _lay_out(every[0].get_figure())
    return every[0].get_figure()


def _lay_out(figure: Any) -> None:
    """Let the layout of a figure, if it has one, place the axes: domes and titles are measured by them.

    Each time the layout takes the room of titles above square axes from where they were the time before.
    """
    for _ in range(2 if figure.get_layout_engine() is not None else 0):
        figure.draw_without_rendering()


def has_colours(picture: Picture) -> bool:
    """Whether any patch has a colour."""
    return any(bool(np.any(dome.has_colour(picture.quantity))) for dome in picture.domes)


def _draw_title(
    axes: Any, title: str, font_pt: float, width_in: float, ruler: Ruler, least: float, **place: float
) -> None:
    """Write a title above axes in lines that are not wider than it may be, with letters of one size."""
    texts = [text for text in plain_text(title).split("\n") if text]
    lines = [one for text in texts for one in _fitting_lines(text, font_pt, width_in, ruler, least)]
    font = min((pt for _, pt in lines), default=font_pt)
    axes.set_title("\n".join(line for line, _ in lines), fontsize=font, **place)


def _fitting_lines(text: str, font_pt: float, width_in: float, ruler: Ruler, least: float) -> list[tuple[str, float]]:
    """A text in one line, in a line for each comma, or in more, with letters as they are or smaller."""
    for pieces, part in (([text], _LEAST_TITLE), (text.split(", "), least)):
        font = min(ruler.fitting_pt(piece, font_pt, width_in) for piece in pieces)
        if font >= part * font_pt:
            return [(piece, font) for piece in pieces]
    font = max(_SMALLEST * font_pt, min(ruler.fitting_pt(word, font_pt, width_in) for word in text.split()))
    return [(line, font) for piece in pieces for line in ruler.even_lines(piece, font, width_in)]


def _draw_bar(
    mesh: Any,
    axes: list[Any],
    colours: Colours,
    width_in: float,
    font_pt: float,
    kind: tuple[float, float, float],
    name: str,
) -> Any:
    """A colour bar with its numbers below axes, which are so wide together."""
    shrink, height_in, number_em = kind
    length_in = shrink * width_in
    place = {"location": "bottom", "shrink": shrink, "aspect": length_in / height_in, "pad": 0.0}
    bar = axes[0].figure.colorbar(mesh, ax=axes, extend=colours.extend, extendfrac=0.025, **place)
    bar.ax.set_label(name)
    tick_numbers(bar, colours, most=int(72 * length_in / (number_em * font_pt)))
    bar.minorticks_off()
    bar.ax.tick_params(labelsize=0.9 * font_pt, pad=2)
    return bar


def _draw_key(figure: Any, picture: Picture, font_pt: float, width_in: float, ruler: Ruler) -> None:
    """The symbols that occur, and what patches without a colour are."""
    present = {mark.symbol for dome in picture.domes for mark in dome.marks}
    keys: list[Symbol | str] = [symbol for symbol in Symbol if symbol in present]
    if not all(dome.is_hemisphere and np.all(dome.has_colour(picture.quantity)) for dome in picture.domes):
        keys.append(picture.quantity.void)
    if not keys:
        return
    lines = optional_module("matplotlib.lines", extra=EXTRA)
    handles = [tuple(lines.Line2D([], [], **style) for style in mark_styles(key, 0.8 * font_pt)) for key in keys]
    overlaid = optional_module("matplotlib.legend_handler", extra=EXTRA).HandlerTuple(ndivide=1, pad=0.0)
    texts = [key.value if isinstance(key, Symbol) else key for key in keys]
    figure.legend(
        handles, texts, handler_map={tuple: overlaid}, loc="outside lower left", frameon=False, borderpad=0.0,
        fontsize=min(ruler.fitting_pt(text, font_pt, width_in - 2.1 * font_pt / 72) for text in texts),
        handlelength=1.6, handletextpad=0.5, labelspacing=0.3, borderaxespad=72 * _PAD_IN / font_pt,
    )  # fmt: skip


class Ruler:
    """Measures text in matplotlib's font, whose letters start at whole dots and so are wider on few dots."""

    def __init__(self, dpi: float) -> None:
        self._renderer = optional_module("matplotlib.backends.backend_agg", extra=EXTRA).RendererAgg(1, 1, dpi)

    def width_in(self, line: str, font_pt: float) -> float:
        """Width of a line. [inch]"""
        properties = optional_module("matplotlib.font_manager", extra=EXTRA).FontProperties(size=font_pt)
        width = self._renderer.get_text_width_height_descent(line, properties, ismath=False)[0]
        return float(width) / float(self._renderer.dpi)

    def fitting_pt(self, line: str, font_pt: float, width_in: float) -> float:
        """Size of the letters of a line that must not be broken: smaller where it would be wider."""
        font_pt *= min(1.0, width_in / self.width_in(line, font_pt))
        while self.width_in(line, font_pt) > width_in:
            font_pt *= 0.98
        return font_pt

    def wrapped(self, text: str, font_pt: float, width_in: float) -> str:
        """Paragraphs in lines."""
        return "\n".join(one for part in plain_text(text).split("\n") for one in self.lines(part, font_pt, width_in))

    def lines(self, text: str, font_pt: float, width_in: float) -> list[str]:
        """Break a paragraph into lines between its words, and within words that are too long."""
        lines: list[str] = []
        for word in text.split():
            longer = f"{lines[-1]} {word}" if lines else word
            if lines and self.width_in(longer, font_pt) <= width_in:
                lines[-1] = longer
                continue
            if self.width_in(word, font_pt) <= width_in:
                lines.append(word)
                continue
            lines.append("")
            for letter in word:
                if lines[-1] and self.width_in(lines[-1] + letter, font_pt) > width_in:
                    lines.append("")
                lines[-1] += letter
        return lines

    def even_lines(self, text: str, font_pt: float, width_in: float) -> list[str]:
        """As few lines as `lines` has, about equally wide."""
        lines = self.lines(text, font_pt, width_in)
        tried = (self.lines(text, font_pt, part * width_in) for part in np.arange(0.5, 1.0, 0.1))
        return next((narrower for narrower in tried if len(narrower) == len(lines)), lines)
