"""Maps of pulls: colours that part at zero, zones that say nothing, pulls without an end."""

import numpy as np
import pytest

from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.panels import figure_of
from aomc_sky.pictures.picture import PULL, pull_picture

pytest.importorskip("matplotlib")

# the first column starts at 10 degrees, the last one ends a turn later
GRID = PatchGrid(
    zenith_bounds_deg=np.array([[0.0, 40.0], [40.0, 90.0]]),
    azimuth_bounds_deg=np.array([[10.0, 130.0], [130.0, 250.0], [250.0, 370.0]]),
)
PULLS = np.array([[0.0, -2.5, 1.0], [np.nan, np.inf, 0.5]])


def mesh_of(figure):
    return figure.axes[0].collections[0]


@pytest.mark.parametrize(
    ("values", "reach", "extend"),
    [(PULLS, 4, "max"), (2 * PULLS, 5, "max"), (np.full((2, 3), -30.0), 8, "min"), (np.zeros((2, 3)), 4, "neither")],
)
def test_colours_part_at_zero(values, reach, extend):
    figure = figure_of(pull_picture([("waveband 1", GRID, values)]), size_px=300)
    norm = mesh_of(figure).norm
    assert type(norm).__name__ == "Normalize"
    assert (norm.vmin, norm.vmax) == (-reach, reach)
    bar = next(axes for axes in figure.axes if axes.get_label() == "colour bar")
    assert bar._colorbar.extend == extend
    assert bar.get_xlabel() == PULL.label
    figure.canvas.draw()


def test_every_zone_has_its_pull_and_a_pull_of_nothing_is_no_colour():
    figure = figure_of(pull_picture([("waveband 1", GRID, PULLS)]), size_px=300)
    shown = mesh_of(figure).get_array()[:, ::60]
    assert shown.mask.tolist() == [[False, False, False], [True, False, False]]
    assert shown[0].tolist() == PULLS[0].tolist()
    assert shown[1, 1] > 1e9  # beyond the end of the bar
    corners = mesh_of(figure).get_coordinates()
    np.testing.assert_allclose(corners[-1, 0], corners[-1, -1], atol=1e-9)  # a whole turn
    assert figure.findobj(lambda artist: hasattr(artist, "get_text") and artist.get_text() == PULL.void)


def test_many_maps_are_spread_and_maps_without_pulls_say_so():
    picture = pull_picture([(f"waveband {k}", GRID, PULLS) for k in range(40)])
    assert len(picture.domes) == 12
    assert picture.domes[-1].title.endswith("largest pull +inf")
    assert any("12 of them" in note for note in picture.notes)
    even, dark = np.full((2, 3), 0.0049), np.full((2, 3), np.nan)
    picture = pull_picture([("waveband 1", GRID, even), ("waveband 2", GRID, dark)])
    assert [word in dome.title for word, dome in zip(("no pull", "too few"), picture.domes, strict=True)] == [True] * 2
