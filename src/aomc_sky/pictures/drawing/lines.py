"""Lines of text that fit into a picture, by the widths that its dots give the letters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from aomc_sky.extras import optional_module
from aomc_sky.pictures.drawing.style import EXTRA


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
