"""Check a built site: nothing comes from another host, words lead to their pages, pictures are there.

python docs/check_site.py HTML_FOLDER
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

FIRST = {
    "weighting": "conventions",
    "azimuth": "conventions",
    "waveband": "conventions",
    "replicates": "error_bars",
    "seed": "cli",
    "compat": "howto/from_aomc",
    "exit codes": "cli",
    "cite": "cite",
    "perez": "models/perez",
    "numba": "hosts",
    "mean cosine": "conventions",
    "shard": "scale",
    "overcast": "howto/own_sky",
    "CSV": "howto/measured_sky",
    "install": "tutorial",
    "conda": "tutorial",
    "Jupyter": "notebooks",
    "PAR": "notebooks",
    "weather": "howto/weather",
    "beam": "howto/own_sky",
    "netCDF": "howto/own_sky",
    "Fortran": "hosts",
    "C++": "hosts",
    "OpenMP": "hosts",
    "MPI": "hosts",
    "Slurm": "hosts",
    "HPC": "hosts",
    "CUDA": "hosts",
    "GPU": "hosts",
    "without Python": "hosts",
    "own sky": "howto/own_sky",
    "wind": "hosts",
    "wave": "hosts",
    "HydroLight": "howto/weather",
    "AERONET": "howto/measured_sky",
    "lux": "howto/weather",
    "HDR": "export",
}
"""What a reader searches for -> the page that the search must show first."""

_LOADED = re.compile(
    r"""<(?:script|img|iframe|source|video)\b[^>]*\bsrc=["']([^"']+)|<link\b[^>]*\bhref=["']([^"']+)"""
)
_IN_STYLE = re.compile(r"""(?:url\(|@import)\s*["']?([^"')\s;]+)""")


def outside_hosts(site: Path) -> list[str]:
    """Files that name another host for what a browser loads with them."""
    wrong = []
    for path in sorted(site.rglob("*")):
        if path.suffix in {".html", ".css"}:
            found = _LOADED.findall(path.read_text()) if path.suffix == ".html" else []
            addresses = [a or b for a, b in found] + _IN_STYLE.findall(
                path.read_text() if path.suffix == ".css" else ""
            )
            wrong += [f"{path.relative_to(site)}: {a}" for a in addresses if re.match(r"(?:https?:)?//", a)]
    return wrong


def misled_words(site: Path) -> list[str]:
    """Words whose page is not the one main entry of the index that the search ranks above all else."""
    index = json.loads((site / "searchindex.js").read_text().removeprefix("Search.setIndex(").removesuffix(")"))
    pages, entries = index["docnames"], index["indexentries"]
    found = {word: [pages[page] for page, _, is_main in entries.get(word.lower(), []) if is_main] for word in FIRST}
    return [f"{word}: {found[word]}, not {page}" for word, page in FIRST.items() if found[word] != [page]]


def lost_pictures(site: Path) -> list[str]:
    """Pictures that a page shows and the site does not have."""
    shown = [
        (page, address)
        for page in sorted(site.rglob("*.html"))
        for address in re.findall(r'<img\b[^>]*\bsrc="([^":#]+)"', page.read_text())
    ]
    return [f"{page.relative_to(site)}: {address}" for page, address in shown if not (page.parent / address).is_file()]


_DRAWN = re.compile(r'<img\b[^>]*\bsrc="[^"]*(?:sphx_glr_|/[0-9a-f]{64}\.png")[^>]*>|<img\b[^>]*alt="figure"[^>]*>')
"""A picture that a program of the gallery or a notebook drew."""


def bright_pictures(site: Path) -> list[str]:
    """Pages on which a picture of the gallery or of a notebook has no twin for dark mode."""
    wrong = []
    for page in sorted(site.rglob("*.html")):
        modes = [re.findall(r"\bonly-(light|dark)\b", image) for image in _DRAWN.findall(page.read_text())]
        if modes.count(["light"]) != modes.count(["dark"]) or [] in modes:
            wrong.append(f"{page.relative_to(site)}: a picture has no twin for dark mode")
    return wrong


def complaints(site: Path) -> list[str]:
    """What is wrong, a line each."""
    return [*outside_hosts(site), *misled_words(site), *lost_pictures(site), *bright_pictures(site)]


if __name__ == "__main__":
    sys.exit("\n".join(complaints(Path(sys.argv[1]))) or 0)
