"""Which extra brings which packages, and which commands want it: for tests in process and in fresh environments."""

import sys
import tomllib
from importlib.abc import MetaPathFinder

from tests.support.shared import DATA, INPUTS, REPOSITORY

HAZY = str(INPUTS / "atmosphere" / "molecules_only.atmo")
NIGHT = str(INPUTS / "night_sky" / "night.h5")
EPW = str(DATA / "weather" / "good" / "invented.epw")
WEATHER = ("perez", "--epsilon", "1.5", "--delta", "0.2", "--sun-zenith", "40")
PLACE = ("--time", "2026-06-21T12:00:00Z", "--latitude", "45", "--longitude", "14")
SUN = ("--wavelength", "500,600", "--bins", "9", "18", "--sun-zenith", "60", "--orders", "2")

PACKAGES = {
    "hdf5": ("h5py",),
    "mcpl": ("mcpl",),
    "netcdf": ("xarray", "h5netcdf", "h5py"),
    "plot": ("matplotlib", "PIL"),
    "weather": ("pvlib", "pandas"),
    "completion": ("shtab",),
    "dask": ("distributed", "dask"),
    "bench": ("mitsuba", "drjit", "PythonicDISORT"),
}
"""Extra of a user -> the packages that our code imports of it."""

DISTRIBUTIONS = {"PIL": "matplotlib", "pandas": "pvlib", "drjit": "mitsuba", "dask": "distributed"}
"""Import name -> the requirement that brings it, where that has another name."""


def extras_of_project():
    """Extra -> names of its requirements, as pyproject.toml has them."""
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    return {
        extra: [requirement.partition(">")[0] for requirement in requirements]
        for extra, requirements in project["optional-dependencies"].items()
    }


def commands_wanting(folder):
    """Extra -> commands that are refused without it; `folder` holds a run of clear_day as `out`."""
    new = str(folder / "new")
    table = ("atmosphere", HAZY, *SUN, "--out-dir", new)
    return {
        "hdf5": [
            ("info", NIGHT),
            ("validate", NIGHT),
            ("run", str(INPUTS / "night_sky"), "--iterations", "100", "--format", "none", "--out", new),
            ("info", NIGHT, "--time", "2026-02-14T21:30:00Z"),
        ],
        "mcpl": [("info", str(folder / "out" / "photons.mcpl")), ("validate", str(folder / "out" / "photons.mcpl"))],
        "netcdf": [("export", str(folder / "out"), "--to", "netcdf", "--out", f"{new}.nc"), table],
        "plot": [
            (*WEATHER, "--plot", f"{new}.png"),
            ("plot", str(INPUTS / "clear_day"), "--out", f"{new}-sky.png"),
            ("plot", str(folder / "out"), "--pull", "--out", f"{new}-pull.svg"),
        ],
        "weather": [("perez", *PLACE, "--dni", "800", "--dhi", "90"), ("perez", "--epw", EPW, "--row", "12")],
        "completion": [("--print-completion", "bash")],
        "dask": [("run", str(INPUTS / "clear_day"), "--iterations", "100", "--engine", "dask", "--out", f"{new}-dask")],
        "bench": [],  # no command wants it; the scripts of bench/ leave absent peers out with a line
    }


def commands_of_core(folder):
    scene, out = str(INPUTS / "clear_day"), str(folder / "out")
    return [
        ("validate", scene),
        ("run", scene, "--iterations", "1000", "--format", "npy", "--format", "mcpl", "--out", out, "--force"),
        ("info", scene),
        ("info", out),
        ("info", HAZY),
        ("verify", out),
        ("export", out, "--to", "csv", "--out", str(folder / "csv"), "--force"),
        WEATHER,
        ("atmosphere", HAZY, *SUN, "--out-dir", str(folder / "tables"), "--no-netcdf"),
    ]


def hint(extra):
    """How the one line ends that tells of a missing extra."""
    return f'pip install ".[{extra}]" in the source folder of aomc-sky, which is in no package index yet\n'


class Absent(MetaPathFinder):
    """Finds nothing of some packages, as if they were not installed."""

    def __init__(self, packages):
        self.packages = packages

    def holds(self, name):
        return name.partition(".")[0] in self.packages

    def find_spec(self, name, path=None, target=None):
        if self.holds(name):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name.partition(".")[0])

    def hide(self, monkeypatch):
        """Forget what was imported already, until the test ends."""
        for name in [name for name in sys.modules if self.holds(name)]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setattr(sys, "meta_path", [self, *sys.meta_path])
