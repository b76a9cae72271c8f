"""Draw the rooms of the package for architecture.md, from the imports of the code and the contract of its layers.

Run from anywhere: python docs/figures/draw_architecture.py [FOLDER]; architecture.svg and rooms.md go to FOLDER, by
default beside this file, the same bytes every time. A test draws both anew and compares them, so the page cannot fall
behind the code. Sentences are the first lines of the rooms' docstrings; the numbered way is `WAY` below, and the script
ends with an error when one of its functions is gone, or when no import leads on to the next.
"""

from __future__ import annotations

import ast
import sys
import textwrap
import tomllib
from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from html import escape
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PACKAGE = ROOT / "src" / "aomc_sky"
WIDTH, MARGIN, GAP, CHIP_GAP = 1180, 16, 14, 24
BLUE, INK, GREY, PAPER, ROOM = "#0072b2", "#1c1c1c", "#5f6b76", "#ffffff", "#f2f5f8"

WAY = (
    ("cli.main", "main", "exit codes, and how errors reach a person"),
    ("cli.commands.run", "run", "options of a run become a scene and a job"),
    ("source.read.scene", "read_scene", "amc.inp and its neighbours become a Scene"),
    ("formats.aomc.amc", "read_amc", "numbers, and where they stood"),
    ("source.scene", "build_plan", "masses, exact counts, keys: the Plan"),
    ("plan.allocation", "allocate", "photons shared out as integers"),
    ("engine.run", "run_job", "the job: blocks of photons on threads"),
    ("emission.photon_source", "PhotonSource", "any photon by its index"),
    ("emission.kernels.emit", "emit", "the compiled loop"),
    ("outputs.photons.npy", "NpyWriter", "photons become files"),
    ("outputs.manifest", "build_manifest", "the manifest closes last"),
)
"""Module, function or class, and what happens there, in the order of ``aomc-sky run amc.inp``."""


@dataclass
class Room:
    """A folder or file at the top of the package."""

    name: str
    sentence: str
    rooms: list[str] = field(default_factory=list)  #: sub-rooms
    uses: set[str] = field(default_factory=set)  #: other rooms that files here import from


def sentence_of(path: Path) -> str:
    """First paragraph of a module's docstring, without its full stop."""
    text = ast.get_docstring(ast.parse(path.read_text())) or sys.exit(f"{path} does not say what it is")
    return " ".join(text.split("\n\n")[0].split()).removesuffix(".")


@cache
def imported(path: Path) -> frozenset[str]:
    """Modules of the package that a file imports, without the package's own name."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("aomc_sky."):
            module = (node.module or "").removeprefix("aomc_sky.")
            found |= {module, *(f"{module}.{alias.name}" for alias in node.names)}
    return frozenset(found)


def read_rooms() -> dict[str, Room]:
    """Every room at the top of the package, by name."""
    rooms = {}
    for top in sorted(PACKAGE.iterdir()):
        if (top / "__init__.py").is_file():
            files = sorted(path for path in top.rglob("*.py") if path.name != "__init__.py")
            subs = sorted(path.parent.name for path in top.glob("*/__init__.py"))
            room = Room(top.name, sentence_of(top / "__init__.py"), subs)
        elif top.suffix == ".py" and not top.stem.startswith("__"):
            files, room = [top], Room(top.stem, sentence_of(top))
        else:
            continue
        for path in files:
            room.uses |= {module.split(".")[0] for module in imported(path)} - {room.name}
        rooms[room.name] = room
    return rooms


def read_layers() -> list[list[str]]:
    """Rooms from the top to the bottom, as the contract of pyproject.toml has them."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    layers = next(c for c in contracts if c["type"] == "layers" and c["containers"] == ["aomc_sky"])["layers"]
    return [layer.split(" | ") for layer in layers]


def check_way() -> None:
    """End with an error unless every station exists and can be reached from the one before, or from one before that."""
    reached = {WAY[0][0]}
    for module, name, _ in WAY:
        path = PACKAGE / Path(*module.split(".")).with_suffix(".py")
        if not path.is_file():
            sys.exit(f"there is no {module}: WAY in {Path(__file__).name} is out of date")
        defined = {
            node.name
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.FunctionDef | ast.ClassDef)
        }
        if name not in defined:
            sys.exit(f"{module} has no {name}: WAY in {Path(__file__).name} is out of date")
        if not any(leads(station, module) for station in reached):
            sys.exit(f"no import leads from {', '.join(sorted(reached))} to {module}")
        reached.add(module)


def leads(start: str, end: str) -> bool:
    """Whether imports lead from one module to another in any number of steps."""
    seen, todo = {start}, [start]
    while todo:
        path = PACKAGE / Path(*todo.pop().split(".")).with_suffix(".py")
        targets = imported(path) | named_lazily(path) if path.is_file() else frozenset()
        todo += targets - seen
        seen |= targets
    return end in seen


@cache
def named_lazily(path: Path) -> frozenset[str]:
    """Modules that a file names in a text, as registries do: ``aomc_sky.room.module:Class`` or with a ``{name}``."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.JoinedStr) and node.values:
            text, is_prefix = getattr(node.values[0], "value", None), True
        else:
            text, is_prefix = getattr(node, "value", None), False
        if not isinstance(text, str) or not text.startswith("aomc_sky."):
            continue
        name = text.removeprefix("aomc_sky.").partition(":")[0]
        if is_prefix:
            files = (file.relative_to(PACKAGE).with_suffix("").parts for file in PACKAGE.rglob("*.py"))
            found |= {module for module in map(".".join, files) if module.startswith(name)}
        else:
            found.add(name)
    return frozenset(found)


class Drawing:
    """SVG text from the top of a page downwards."""

    def __init__(self) -> None:
        self.shapes: list[str] = []
        self.y = MARGIN
        self.spots: dict[str, tuple[float, float]] = {}  #: room or room.sub-room -> where its number may stand

    def text(self, x: float, y: float, words: str, size: int = 12, colour: str = INK, weight: str = "normal") -> None:
        """Write words; y is the line that they stand on."""
        self.shapes.append(
            f'<text x="{x:.0f}" y="{y:.0f}" font-size="{size}" fill="{colour}" font-weight="{weight}">'
            f"{escape(words)}</text>"
        )

    def box(self, x: float, y: float, width: float, height: float, fill: str, line: str) -> None:
        """Draw a rectangle with round corners."""
        self.shapes.append(
            f'<rect x="{x:.0f}" y="{y:.0f}" width="{width:.0f}" height="{height:.0f}" rx="5" '
            f'fill="{fill}" stroke="{line}"/>'
        )

    def layer(self, rooms: list[Room], depth: dict[str, int]) -> None:
        """One band: its rooms side by side, all of one height."""
        width = (WIDTH - 2 * MARGIN - GAP * (len(rooms) - 1)) / len(rooms)
        parts = [self.lines_of(room, width, depth) for room in rooms]
        height = max(len(sentence) * 15 + len(chips) * 24 + len(uses) * 14 for sentence, chips, uses in parts) + 34
        for k, (room, (sentence, chips, uses)) in enumerate(zip(rooms, parts, strict=True)):
            x, y = MARGIN + k * (width + GAP), self.y
            self.box(x, y, width, height, ROOM, "#c3ccd4")
            self.text(x + 10, y + 20, room.name, 14, INK, "bold")
            self.spots[room.name] = (x + 26 + 9.6 * len(room.name), y + 15)
            y += 24
            for line in sentence:
                y += 15
                self.text(x + 10, y, line)
            y += 6
            for row in chips:
                left = x + 10
                for name in row:
                    wide = chip_width(name)
                    self.box(left, y, wide, 19, PAPER, "#aab6c0")
                    self.text(left + 6, y + 14, f"{name}/", 11)
                    self.spots[f"{room.name}.{name}"] = (left + wide + 11, y + 10)
                    left += wide + CHIP_GAP
                y += 24
            for line in uses:
                y += 14
                self.text(x + 10, y - 2, line, 10, GREY)
        self.y += height + GAP

    @staticmethod
    def lines_of(room: Room, width: float, depth: dict[str, int]) -> tuple[list[str], list[list[str]], list[str]]:
        """The sentence, the rows of sub-rooms and the rooms used, broken to a width."""
        sentence = textwrap.wrap(room.sentence, int((width - 20) / 6.1))
        rows: list[list[str]] = [[]]
        left = 0.0
        for name in room.rooms:
            if left + chip_width(name) > width - 20:
                rows.append([])
                left = 0.0
            rows[-1].append(name)
            left += chip_width(name) + CHIP_GAP
        used = sorted(room.uses, key=lambda name: (depth[name], name))
        text = f"uses {', '.join(used)}" if used else ""
        return sentence, rows if room.rooms else [], textwrap.wrap(text, int((width - 20) / 5.0))

    def way(self) -> None:
        """The numbered stations, and what they mean below the rooms."""
        taken: Counter[str] = Counter()
        places = []
        for module, _, _ in WAY:
            parts = module.split(".")
            spot = ".".join(parts[:2]) if ".".join(parts[:2]) in self.spots else parts[0]
            x, y = self.spots[spot]
            places.append((x + 19 * taken[spot], y))
            taken[spot] += 1
        for number, (x, y) in enumerate(places, 1):
            self.shapes.append(f'<circle cx="{x:.0f}" cy="{y:.0f}" r="8.5" fill="{BLUE}"/>')
            self.text(x - (4 if number < 10 else 7), y + 4, str(number), 11, PAPER, "bold")
        self.text(MARGIN, self.y + 14, "aomc-sky run amc.inp, from the command to the kernel and back", 13, INK, "bold")
        half = (len(WAY) + 1) // 2
        for number, (module, name, words) in enumerate(WAY, 1):
            x = MARGIN + (number > half) * (WIDTH / 2)
            y = self.y + 38 + 22 * ((number - 1) % half)
            self.shapes.append(f'<circle cx="{x + 9:.0f}" cy="{y - 4:.0f}" r="8.5" fill="{BLUE}"/>')
            self.text(x + (5 if number < 10 else 2), y, str(number), 11, PAPER, "bold")
            self.text(x + 26, y, f"{module}.{name}: {words}", 11)
        self.y += 38 + 22 * half

    def svg(self) -> str:
        """Return the whole drawing."""
        return "\n".join(
            [
                f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {self.y:.0f}" width="{WIDTH}" '
                f'height="{self.y:.0f}" font-family="DejaVu Sans, Verdana, sans-serif">',
                f'<rect width="{WIDTH}" height="{self.y:.0f}" fill="{PAPER}"/>',
                *self.shapes,
                "</svg>",
                "",
            ]
        )


def chip_width(name: str) -> float:
    """Width of a sub-room's label in the drawing."""
    return 6.4 * len(f"{name}/") + 12


def table(rooms: dict[str, Room], layers: list[list[str]]) -> str:
    """Every room with its sentence, as Markdown."""
    rows = (f"| **{name}** | {rooms[name].sentence} |" for layer in layers for name in layer)
    return "\n".join(["| room | what it is |", "| --- | --- |", *rows, ""])


def main(folder: Path) -> None:
    """Write both files."""
    check_way()
    rooms, layers = read_rooms(), read_layers()
    depth = {name: k for k, layer in enumerate(layers) for name in layer}
    drawing = Drawing()
    for layer in layers:
        drawing.layer([rooms[name] for name in layer], depth)
    drawing.way()
    (folder / "architecture.svg").write_text(drawing.svg())
    (folder / "rooms.md").write_text(table(rooms, layers))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
