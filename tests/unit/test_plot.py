"""The picture of a sky: whole or not at all, with its conventions, and the sun where it should be."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from aomc_sky import plot
from aomc_sky.errors import MissingExtraError, OutputError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.plot import plot_sky
from aomc_sky.skies.uniform import UniformSky

pytest.importorskip("matplotlib")


class Spot:
    """A sky that is bright around one place."""

    sun_zenith_rad = float(np.deg2rad(45.0))
    sun_azimuth_rad = float(np.deg2rad(30.0))
    dhi = 100.0

    def radiance(self, sky_zenith_rad, sky_azimuth_rad, wavelength_nm):
        near = (sky_zenith_rad - self.sun_zenith_rad) ** 2 + (sky_azimuth_rad - self.sun_azimuth_rad) ** 2
        return np.exp(-20 * near) + 1e-5


@pytest.fixture
def figures(monkeypatch):
    """The figures that plot_sky makes, in order."""
    made = []
    dome = plot._dome

    def watched(*arguments):
        made.append(dome(*arguments))
        return made[-1]

    monkeypatch.setattr(plot, "_dome", watched)
    return made


def pixels(figure):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].astype(float)


def test_the_bright_place_and_its_mark_lie_to_the_upper_right(tmp_path, figures):
    path = tmp_path / "sky.png"
    plot_sky(Spot(), path, title="a spot")
    assert path.read_bytes().startswith(b"\x89PNG")
    axes = figures[0].axes[0]
    colours = axes.collections[0].get_array().reshape(180, 720)
    ring, column = np.unravel_index(int(colours.argmax()), colours.shape)
    assert abs(ring / 2 - 45) <= 1
    assert abs(column / 2 - 30) <= 1
    assert axes.lines[0].get_xydata()[0] == pytest.approx([np.deg2rad(30.0), 45.0])
    # on the page: right of the centre and above it
    x, y = axes.transData.transform(axes.lines[0].get_xydata()[0]) - axes.transData.transform((0.0, 0.0))
    assert x > 0
    assert y > 0
    assert np.arctan2(y, x) == pytest.approx(np.deg2rad(30.0), abs=1e-6)


def test_the_picture_says_what_it_shows(tmp_path, figures):
    plot_sky(Spot(), tmp_path / "sky.svg", title="a spot")
    figure = figures[0]
    texts = [text.get_text() for text in figure.findobj(lambda artist: hasattr(artist, "get_text"))]
    assert "a spot" in texts
    assert any("+x (east) towards +y (north)" in text for text in texts)
    assert any("W m" in text and "sr" in text for text in texts)
    assert any("E, +x" in text for text in texts)
    assert "sun" in texts


@pytest.mark.parametrize(
    ("values", "scale", "low", "high"),
    [
        (np.linspace(1.0, 9.0, 32).reshape(4, 8), "Normalize", 1.0, 9.0),
        (np.geomspace(1.0, 1e3, 32).reshape(4, 8), "LogNorm", 1.0, 1e3),
        (np.geomspace(1e-9, 1.0, 32).reshape(4, 8), "LogNorm", 1e-4, 1.0),
        (np.where(np.arange(32) < 4, 0.0, 1.0).reshape(4, 8), "LogNorm", 1.0, 1.0),
        (np.zeros((4, 8)), "Normalize", 0.0, 1.0),
        (np.full((4, 8), 7.0), "Normalize", 0.0, 7.0),
    ],
)
def test_colours_are_logarithmic_where_the_range_is_large(values, scale, low, high, tmp_path, figures):
    plot_sky(values, tmp_path / "sky.png")
    mesh = figures[0].axes[0].collections[0]
    assert type(mesh.norm).__name__ == scale
    assert (mesh.norm.vmin, mesh.norm.vmax) == pytest.approx((low, high))
    assert np.all(np.isfinite(pixels(figures[0])))


def test_values_of_patches_come_zenith_major(tmp_path, figures):
    grid = PatchGrid.regular(3, 4)
    plot_sky(np.arange(1.0, 13.0), tmp_path / "sky.png", grid=grid)
    assert figures[0].axes[0].collections[0].get_array().reshape(3, 4)[1].tolist() == [5, 6, 7, 8]


def test_models_without_a_sun_have_no_mark(tmp_path, figures):
    plot_sky(UniformSky(), tmp_path / "sky.pdf")
    assert len(figures[0].axes[0].lines) == 0
    plot_sky(UniformSky(), tmp_path / "sky.pdf", sun_deg=(20.0, 350.0))
    assert len(figures[1].axes[0].lines) == 2


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_equal_skies_give_equal_files(suffix, tmp_path):
    for name in ("a", "b"):
        plot_sky(Spot(), tmp_path / f"{name}{suffix}")
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize(
    ("sky", "name", "grid"),
    [
        (UniformSky(), "sky.txt", None),
        (np.zeros(12), "sky.png", None),
        (np.zeros(11), "sky.png", PatchGrid.regular(3, 4)),
        (np.array([[1.0, np.nan]]), "sky.png", None),
    ],
)
def test_what_cannot_be_drawn_is_refused(sky, name, grid, tmp_path):
    with pytest.raises(UsageError):
        plot_sky(sky, tmp_path / name, grid=grid)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(OutputError):
        plot_sky(UniformSky(), tmp_path / "absent" / "sky.png")


def test_without_matplotlib_the_extra_is_named(monkeypatch, tmp_path):
    for name in [name for name in sys.modules if name.partition(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=r"aomc-sky\[plot\]"):
        plot_sky(UniformSky(), tmp_path / "sky.png")


def test_no_window_system_is_needed(tmp_path):
    code = "import sys; from aomc_sky.plot import plot_sky; from aomc_sky import UniformSky;"
    code += "plot_sky(UniformSky(), sys.argv[1]); assert 'matplotlib.pyplot' not in sys.modules"
    environment = {k: v for k, v in os.environ.items() if k != "DISPLAY"} | {"MPLBACKEND": "TkAgg"}
    command = [sys.executable, "-c", code, tmp_path / "sky.png"]
    subprocess.run(command, env=environment, timeout=120, check=True)
    assert (tmp_path / "sky.png").exists()
