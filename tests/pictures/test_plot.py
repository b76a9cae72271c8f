"""`sky.plot` and maps of pulls: what is drawn, where it lies, what the picture says, and its files."""

import io
import itertools

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.grid import PatchGrid
from aomc_sky.pictures.dome import round_numbers
from aomc_sky.pictures.panels import figure_of
from aomc_sky.pictures.picture import (
    PULL,
    RELATIVE_RADIANCE,
    Dome,
    Mark,
    Picture,
    Symbol,
    direction_words,
    pull_picture,
)
from aomc_sky.pictures.source import sun_mark
from tests.support.processes import in_environment
from tests.support.sampled import grid_of_edges
from tests.support.shared import INPUTS

rc_context = pytest.importorskip("matplotlib").rc_context
Figure = pytest.importorskip("matplotlib.figure").Figure


def dome_axes(figure, number=1):
    return next(axes for axes in figure.axes if axes.get_label() == f"dome {number}")


def mesh_of(figure, number=1):
    return dome_axes(figure, number).collections[0]


def key_of(figure):
    (key,) = figure.findobj(lambda artist: type(artist).__name__ == "Legend")
    return key


def texts_of(figure):
    return [text.get_text() for text in figure.findobj(lambda artist: hasattr(artist, "get_text"))]


def marks_of(figure, number=1):
    lines = {line.get_gid() or "": line.get_xydata()[0] for line in dome_axes(figure, number).lines}
    return {name: where for name, where in lines.items() if name.startswith("mark-")}


def drawn(*domes, size=300):
    return figure_of(Picture(domes=domes, quantity=RELATIVE_RADIANCE), size_px=size)


def even_dome(**more):
    return Dome(grid=PatchGrid.regular(2, 4), values=np.ones(8), **more)


def one_bright(ring, column, n_zenith=3, n_azimuth=8):
    values = np.ones((n_zenith, n_azimuth))
    values[ring, column] = 100.0
    return values


def brightest_pixel(figure):
    """Where on the page the brightest patch is: right and up from the centre of the dome, in parts of its radius."""
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(int)
    yellow = np.abs(pixels - [253, 231, 36]).max(axis=-1) <= 3
    yellow[int(0.87 * yellow.shape[0] * 0.96) :] = False  # the colour bar
    up, right = np.nonzero(yellow)
    axes = dome_axes(figure)
    x0, y0 = axes.transData.transform((0.0, 0.0))
    radius = axes.transData.transform((90.0, 0.0))[0] - x0
    return (right.mean() - x0) / radius, (pixels.shape[0] - up.mean() - y0) / radius


@pytest.mark.parametrize(
    ("azimuth_deg", "seen_from", "right", "up"),
    [(90, "above", 0, 1), (0, "above", 1, 0), (180, "above", -1, 0), (90, "below", 0, 1), (0, "below", -1, 0)],
)
def test_a_bright_patch_lies_where_its_azimuth_says(azimuth_deg, seen_from, right, up):
    # a column of 10 degrees around the azimuth, in the ring from 30 to 60 degrees
    grid = grid_of_edges(np.array([0.0, 30.0, 60.0, 90.0]), np.arange(37) * 10.0 - 5.0)
    figure = sky.plot(one_bright(1, azimuth_deg // 10, 3, 36), grid=grid, seen_from=seen_from, size_px=400)
    x, y = brightest_pixel(figure)
    assert (x, y) == pytest.approx((0.5 * right, 0.5 * up), abs=0.04)


def test_patches_are_exact_polygons():
    figure = sky.plot(np.arange(1.0, 13.0).reshape(3, 4))
    mesh = mesh_of(figure)
    corners = mesh.get_coordinates()
    radius = np.hypot(corners[..., 0], corners[..., 1])
    np.testing.assert_allclose(radius, np.repeat([[0.0], [30.0], [60.0], [90.0]], 181, axis=1), atol=1e-12)
    # every column of 90 degrees is drawn as 45 of two, all of one value
    assert mesh.get_array().tolist() == np.arange(1.0, 13.0).reshape(3, 4).repeat(45, axis=1).tolist()
    np.testing.assert_allclose(corners[3, 45], (0.0, 90.0), atol=1e-12)  # azimuth 90 is up


def test_a_direction_in_words_and_the_sun_where_all_domes_have_it():
    assert direction_words(0.0, 70.0) == "at the zenith"
    northwest = "32.4° from the zenith in the northwest (azimuth 121.3°, compass 328.7°)"
    assert direction_words(32.42, 121.26) == northwest
    one, other = (even_dome(marks=(sun_mark(zenith, 0.0),)) for zenith in (30.0, 40.0))
    assert Picture(domes=(one, one), quantity=RELATIVE_RADIANCE).sun_sentence != ()
    assert Picture(domes=(one, other), quantity=RELATIVE_RADIANCE).sun_sentence == ()


def test_the_azimuth_of_the_sun_may_be_that_of_a_compass():
    for convention in ("north_clockwise", "clockwise from north", sky.directions.AzimuthConvention.NORTH_CLOCKWISE):
        figure = sky.plot(sky.UniformSky(), sun_deg=(60.0, 90.0), azimuth_convention=convention)
        assert marks_of(figure)["mark-sun"] == pytest.approx((60.0, 0.0), abs=1e-9)  # in the east
    for convention in ("compass", "clockwise from the sun"):
        with pytest.raises(UsageError, match="convention"):
            sky.plot(sky.UniformSky(), sun_deg=(60.0, 90.0), azimuth_convention=convention)


def test_the_sun_is_marked_where_a_sky_has_one():
    assert marks_of(sky.plot(sky.read_scene(INPUTS / "overcast"))) == {}  # amc.inp says 0, 0
    for name in ("overcast", "uniform"):
        assert marks_of(sky.plot(sky.read_scene(INPUTS / "clear_day", sky=name))) == {}  # amc.inp says 35, 0
    assert marks_of(sky.plot(sky.UniformSky())) == {}
    assert set(marks_of(sky.plot(sky.UniformSky(), sun_deg=(20.0, 350.0)))) == {"mark-sun"}
    below = marks_of(sky.plot(sky.UniformSky(), sun_deg=(130.0, 90.0)))["mark-sun_below"]
    assert below == pytest.approx((0.0, 84.0), abs=1e-9)  # inside the rim
    figure = sky.plot(sky.read_scene(INPUTS / "clear_day" / "amc.inp"), bands=[0], size_px=300)
    ((name, where),) = marks_of(figure).items()
    assert name == "mark-sun_of_amc"
    assert where == pytest.approx((35.0, 0.0))


@pytest.mark.parametrize(
    ("values", "limits", "low", "high", "extend"),
    [
        (np.geomspace(1.0, 1e3, 32), None, 1.0, 1e3, "neither"),
        (np.geomspace(1.0, 1e3, 32), (10.0, 100.0), 10.0, 100.0, "both"),
        (np.geomspace(1e-9, 1.0, 32), None, 1e-4, 1.0, "min"),
        (np.where(np.arange(32) < 4, 0.0, 1.0), None, 2**-0.5, 2**0.5, "neither"),
        (np.full(32, 7.0), None, 7 * 2**-0.5, 7 * 2**0.5, "neither"),
        (np.full(32, 5e-324), None, None, None, "min"),
    ],
)
def test_colours_are_logarithmic_over_four_decades_at_most(values, limits, low, high, extend):
    figure = sky.plot(values.reshape(4, 8), limits=limits)
    norm = mesh_of(figure).norm
    assert type(norm).__name__ == "LogNorm"
    if low is not None:
        assert (norm.vmin, norm.vmax) == pytest.approx((low, high))
    bar = next(axes for axes in figure.axes if axes.get_label() == "colour bar")
    assert bar._colorbar.extend == extend
    figure.canvas.draw()


def test_patches_without_light_have_their_own_colour_and_are_explained():
    figure = sky.plot(np.where(np.arange(32) < 4, 0.0, 1.0).reshape(4, 8))
    mesh = mesh_of(figure)
    assert np.array_equal(mesh.get_array().mask[0], np.repeat(np.arange(8) < 4, 23))
    assert mesh.cmap.get_bad()[:3] == pytest.approx([0xD4 / 255] * 3)
    assert "no light" in texts_of(figure)
    assert "no light" not in texts_of(sky.plot(np.ones((4, 8))))


def test_edges_of_patches_have_no_jags():
    """A dot on an edge has the mean of its area, as a picture with eight times the dots shows it."""
    values = np.ones((45, 24))
    values[:, 5:12], values[20:30] = 100.0, 50.0
    figure = Figure(figsize=(4, 4), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    sky.plot(values, ax=axes, norm="linear", cmap="gray")
    for line in list(axes.lines):
        line.remove()
    coarse, fine = (red_dots(figure, dpi) for dpi in (100, 800))
    x, y = np.meshgrid(np.arange(-199.5, 200), np.arange(-199.5, 200))
    difference = (coarse - fine.reshape(400, 8, 400, 8).mean(axis=(1, 3)))[np.hypot(x, y) < 170]
    assert np.sqrt(np.mean(difference**2)) < 4.0  # of 255; 2.0 here, 13.7 where corners are moved to whole dots


def red_dots(figure, dpi):
    file = io.BytesIO()
    figure.savefig(file, format="rgba", dpi=dpi)
    return np.frombuffer(file.getvalue(), np.uint8).reshape(4 * dpi, 4 * dpi, 4)[..., 0].astype(float)


def scene_of(*wavelengths, mass=(1.0, 100.0)):
    values = np.outer(mass, np.linspace(1.0, 2.0, 12))
    table = sky.TabulatedSky(wavelength_nm=wavelengths, values=values, grid=PatchGrid.regular(3, 4))
    return sky.Scene(wavebands=list(wavelengths), n_photons=[10, 10**6], components=table)


def test_each_dome_has_its_own_bar_on_request():
    shared = sky.plot(scene_of(400.0, 500.0), show="counts")
    each = sky.plot(scene_of(400.0, 500.0), show="counts", scale="each")
    assert [mesh_of(shared, k).norm.vmax for k in (1, 2)] == [mesh_of(shared, 1).norm.vmax] * 2
    assert mesh_of(each, 1).norm.vmax < 1e-4 * mesh_of(each, 2).norm.vmax
    assert sum("bar" in axes.get_label() for axes in each.axes) == 2
    assert sum("photons per steradian" in text for text in texts_of(each)) == 1


def test_domes_go_into_axes_of_your_own():
    scene, figure = scene_of(400.0, 500.0), Figure(figsize=(8, 4))
    axes = figure.subplots(1, 2)
    assert sky.plot(scene, ax=axes, cmap="magma", norm="linear", limits=(0.0, 3.0)) is figure
    for one, nm in zip(axes, ("400 nm", "500 nm"), strict=True):
        mesh = one.collections[-1]
        assert (mesh.cmap.name, mesh.norm.vmin, mesh.norm.vmax, nm in one.get_title()) == ("magma", 0.0, 3.0, True)
    figure.colorbar(axes[0].collections[-1], ax=axes)
    for path, given in ((None, axes[0]), ("a.png", axes)):  # 1 for 2 domes; a figure that is not ours to save
        with pytest.raises(UsageError):
            sky.plot(scene, path, ax=given)


def test_a_norm_of_matplotlib_is_taken_and_not_changed():
    from matplotlib.colors import PowerNorm

    given = PowerNorm(0.5)
    norm = mesh_of(sky.plot(np.arange(1.0, 13.0).reshape(3, 4), norm=given)).norm
    assert (norm.gamma, norm.vmin, norm.vmax, given.vmin) == (0.5, 1.0, 12.0, None)


@pytest.mark.parametrize(
    ("scale", "light", "size"), [("shared", 1.0, 300), ("each", 1.0, 300), ("each", 2e-12, 300), ("each", 2e-12, 960)]
)
@pytest.mark.parametrize("n", [1, 3, 5, 12])
def test_domes_are_round_of_one_size_in_full_rows_and_fill_the_figure(n, scale, light, size):
    """The height of the figure follows from the layout, also where wide numbers of bars make domes narrower."""
    grid, values, marks = PatchGrid.regular(2, 4), light * np.geomspace(1.0, 10.0, 8), (sun_mark(30.0, 0.0),)
    titles = ["\n".join(["waveband"] * (k + 1)) for k in range(n)]
    domes = tuple(Dome(grid=grid, values=values, title=title, marks=marks) for title in titles)
    picture = Picture(domes=domes, quantity=RELATIVE_RADIANCE, title="a title", notes=("a long note " * 9,))
    figure = figure_of(picture, size_px=size, scale=scale)
    figure.canvas.draw()
    axes = [dome_axes(figure, k + 1) for k in range(n)]
    corners = np.array([one.transData.transform([(-90.0, -90.0), (90.0, 90.0)]) for one in axes])
    sizes = corners[:, 1] - corners[:, 0]
    np.testing.assert_allclose(sizes, sizes[0, 0], atol=0.5)
    boxes = [one.get_position() for one in axes]
    for bottom in {round(box.y0, 6) for box in boxes}:
        row = [box for box in boxes if round(box.y0, 6) == bottom]
        assert row[0].x0 == pytest.approx(1 - row[-1].x1)
        assert all(right.x0 > left.x1 + 0.01 for left, right in itertools.pairwise(row))
    letters_in = 2 * (0.07 + 0.04 + 0.8 * 10.0 / 72)  # the margin, a gap, E and W
    for one in axes:  # no gap above or below
        assert one.get_position(original=True).height < 1.02 * one.get_position().height
    in_row, least = {1: 1, 3: 3, 5: 3, 12: 4}[n], 1.0 if light == 1.0 else 0.75
    assert sizes[0, 0] >= least * (size / in_row - letters_in * figure.dpi) - 0.5
    bars = [one.get_window_extent() for one in figure.axes if one.get_label().startswith("colour bar")]
    assert len(bars) == (1 if scale == "shared" else n)
    souths = [text.get_window_extent() for one in axes for text in one.texts if text.get_text() == "S"]
    for bar, text in itertools.product(bars, [*souths, *(one.title.get_window_extent() for one in axes)]):
        assert not bar.padded(1.0).overlaps(text)


def test_what_no_patch_covers_has_no_light_either():
    """Without any light there is no colour bar, and no picture of a scene."""
    bounds = PatchGrid.regular(3, 8)
    cap = PatchGrid(zenith_bounds_deg=bounds.zenith_bounds_deg[:1], azimuth_bounds_deg=bounds.azimuth_bounds_deg)
    figure = sky.plot(np.ones(8), grid=cap, size_px=400)
    assert "no light" in texts_of(figure)
    figure.canvas.draw()
    x, y = dome_axes(figure).transData.transform((0.0, -45.0))
    pixels = np.asarray(figure.canvas.buffer_rgba())
    assert pixels[pixels.shape[0] - int(y), int(x) + 6, :3].tolist() == [0xD4] * 3
    figure = sky.plot(np.zeros((4, 8)))
    assert [axes.get_label() for axes in figure.axes] == ["dome 1"]
    assert [text.get_text() for text in key_of(figure).get_texts()] == ["no light"]
    figure.canvas.draw()
    with pytest.raises(SceneError):
        sky.plot(scene_of(400.0, 500.0, mass=(0.0, 0.0)))


@pytest.mark.parametrize(("low", "high"), [(1.0, 1e4), (0.14, 0.42), (3e-9, 7e-9), (0.999, 1.001), (1e-300, 1e-296)])
@pytest.mark.parametrize("most", [5, 15])
def test_numbers_of_the_bar_are_few_and_inside(low, high, most):
    found = round_numbers(low, high, most)
    assert len(found) <= most
    assert all(after / before >= (high / low) ** (0.999 / most) for before, after in itertools.pairwise(found))
    assert all(low * (1 - 1e-8) <= value <= high * (1 + 1e-8) for value in found)
    if high / low > 1.2:
        assert len(found) >= 2


@pytest.mark.parametrize("size", [300, *(pytest.param(size, marks=pytest.mark.slow) for size in (640, 2000))])
def test_nothing_is_cut_and_no_labels_touch(size):
    title = "a long title of a picture that has to go into several lines " * 2
    domes = [even_dome(title=f"waveband {k}, 440 nm\nbeam 55 % of the light") for k in range(1, 13)]
    for figure in (
        sky.plot(one_bright(1, 2), sun_deg=(45, 30), title=title, size_px=size),
        drawn(*domes[:3], size=size),
        drawn(*domes, size=size),
    ):
        figure.canvas.draw()
        width, height = figure.canvas.get_width_height()
        assert width == size
        texts = [t for t in figure.findobj(lambda a: type(a).__name__ == "Text") if t.get_text() and t.get_visible()]
        boxes = [(text.get_text(), text.get_window_extent()) for text in texts]
        for text, box in boxes:
            assert min(box.x0, box.y0, width - box.x1, height - box.y1) >= -1, (size, text, box)
        for (text, box), (other, other_box) in itertools.combinations(boxes, 2):
            assert not other_box.shrunk(0.98, 0.8).overlaps(box.shrunk(0.98, 0.8)), (size, text, other)


@pytest.mark.parametrize(("pt", "size", "n"), [(10.0, 390, 3), (16.0, 390, 3), (16.0, 960, 3), (10.0, 390, 12)])
def test_every_ring_has_its_degrees_and_lines_of_letters_stay_inside(pt, size, n):
    mark = Mark(zenith_deg=30.0, azimuth_deg=0.0, symbol=Symbol.SUN_OF_AMC)
    with rc_context({"font.size": pt}):
        figure = drawn(*[even_dome(marks=(mark,))] * n, size=size)
    figure.canvas.draw()
    for axes in figure.axes[:n]:
        below = {text.get_text(): text for text in axes.texts if text.get_text() in ("S", "30°", "60°", "90°")}
        assert {"S", "90°"} <= set(below)  # a small dome leaves 60° out, and then 30°; its marks stand
        assert "30°" in below or "60°" not in below
        assert below["90°"].get_fontsize() == pytest.approx(0.8 * below["S"].get_fontsize())
        boxes = sorted((text.get_window_extent() for text in below.values()), key=lambda box: box.x0)
        assert all(right.x0 - left.x1 >= 1.0 for left, right in itertools.pairwise(boxes)), list(below)
        upright = [line.get_xdata() for line in axes.lines if len(line.get_xdata()) == 2]
        assert sum(x[0] == x[1] > 0 for x in upright) == 3
    caption = next(text for text in figure.texts if "north (+y)" in text.get_text())
    key = key_of(figure)
    (strokes,) = key.legend_handles
    x, y = strokes.get_transform().transform(strokes.get_xydata()).mean(axis=0)
    half = (strokes.get_markersize() / 2 + strokes.get_path_effects()[0]._gc["linewidth"]) * figure.dpi / 72
    assert y - half > caption.get_window_extent().y1
    assert x - half >= 0
    for text in (*key.get_texts(), figure.axes[n].xaxis.label):
        box = text.get_window_extent()
        assert 0 <= box.x0 < box.x1 <= size


@pytest.mark.parametrize("size", [300, 640])
def test_the_word_azimuth_does_not_touch_its_number(size):
    figure = drawn(even_dome(), size=size)
    figure.canvas.draw()
    (text,) = (text for text in figure.axes[0].texts if text.get_text().startswith("azimuth"))
    box, dots = text.get_window_extent(), np.asarray(figure.canvas.buffer_rgba())[::-1, :, 0]
    is_inked = (dots[int(box.y0) : int(box.y1) + 1, int(box.x0) : int(box.x1) + 1] < 200).any(axis=1)
    rows = np.flatnonzero(is_inked)
    assert np.diff(rows).max() >= 3  # two empty rows between the lines


@pytest.mark.parametrize(
    ("n", "pt", "layout"),
    [(1, 10.0, "constrained"), (2, 10.0, None), (3, 10.0, "constrained"), (2, 7.0, "constrained"), (1, 10.0, None)],
)
def test_titles_of_your_own_axes_hold_at_84_mm(n, pt, layout):
    scene = sky.Scene(wavebands=[400.0, 500.0, 600.0], n_photons=10, components="uniform")
    with rc_context({"font.size": pt}):
        figure = Figure(figsize=(84 / 25.4, 60 / 25.4), dpi=300, layout=layout)
        axes = np.atleast_1d(figure.subplots(1, n))
        title = "Clear sky of Perez, the sun at 32 degrees from the zenith" if n == 1 else ""
        sky.plot(scene, bands=range(n), ax=axes, title=title)
        figure.canvas.draw()
        boxes = [one.title.get_window_extent() for one in axes]
    for one, box in zip(axes, boxes, strict=True):
        words = "waveband" if n > 1 else "Clear sky of Perez"
        assert words in one.get_title()
        assert 0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert box.y1 <= figure.bbox.y1 or layout is None
        assert one.title.get_fontsize() >= 0.6 * 1.2 * pt
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(boxes))


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_equal_skies_give_equal_files(suffix, tmp_path):
    for name in ("a", "b"):
        sky.plot(one_bright(1, 2), tmp_path / f"{name}{suffix}", sun_deg=(45, 30), size_px=400)
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize(
    ("what", "options"),
    [
        (sky.UniformSky(), {"path": "sky.txt"}), (np.zeros(12), {}),
        (np.zeros(11), {"grid": PatchGrid.regular(3, 4)}), (np.array([[1.0, np.nan]]), {}),
        (np.ones((3, 4)), {"limits": (2.0, 1.0)}), (np.ones((3, 4)), {"limits": (0.0, 1.0)}),
        (np.ones((3, 4)), {"cmap": "virdis"}), (np.ones((3, 4)), {"norm": "square"}),
        (np.ones((3, 4)), {"scale": "both"}), (np.ones((3, 4)), {"size_px": 20}),
        (np.ones((3, 4)), {"seen_from": "aside"}), (np.ones((3, 4)), {"show": "counts"}),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_is_refused(what, options, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError):
        sky.plot(what, **options)
    assert list(tmp_path.iterdir()) == []


def test_no_window_system_is_needed(tmp_path):
    code = "import sys, aomc_sky as sky; sky.plot(sky.UniformSky(), sys.argv[1], size_px=300);"
    code += "assert 'matplotlib.pyplot' not in sys.modules; assert callable(sky.plot)"
    in_environment(code, tmp_path / "sky.png", DISPLAY="", MPLBACKEND="TkAgg")
    assert (tmp_path / "sky.png").exists()


def _brightness(colour, below=None):
    """Relative luminance of WCAG 2.1; a colour with alpha lies on the one below."""
    from matplotlib.colors import to_rgb, to_rgba

    *rgb, alpha = to_rgba(colour)
    rgb = np.array(rgb) * alpha + (1 - alpha) * np.array(to_rgb(below) if below is not None else (0.0, 0.0, 0.0))
    linear = np.where(rgb <= 0.03928, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("style", ["default", "dark_background", "ggplot"])
def test_letters_can_be_read_in_any_style_of_the_user(style):
    """Letters were white on white in dark_background; 4.5 is the contrast that WCAG asks of small letters."""
    import matplotlib.style
    from matplotlib.text import Text

    scene = sky.Scene(wavebands=[443.0, 555.0], n_photons=10, components="uniform")
    with matplotlib.style.context(style):
        figure = sky.plot(scene)
    ground = figure.get_facecolor()
    texts = [text for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    assert len(texts) > 15
    for text in texts:
        colour = (*matplotlib.colors.to_rgb(text.get_color()), 1.0 if text.get_alpha() is None else text.get_alpha())
        low, high = sorted([_brightness(colour, ground), _brightness(ground)])
        assert (high + 0.05) / (low + 0.05) >= 4.5, (text.get_text(), colour, ground)


# ---- maps of pulls: colours that part at zero, zones that say nothing, pulls without an end ----


# the first column starts at 10 degrees, the last one ends a turn later
PULL_GRID = PatchGrid(
    zenith_bounds_deg=np.array([[0.0, 40.0], [40.0, 90.0]]),
    azimuth_bounds_deg=np.array([[10.0, 130.0], [130.0, 250.0], [250.0, 370.0]]),
)
PULLS = np.array([[0.0, -2.5, 1.0], [np.nan, np.inf, 0.5]])


@pytest.mark.parametrize(
    ("values", "reach", "extend"),
    [(PULLS, 4, "max"), (2 * PULLS, 5, "max"), (np.full((2, 3), -30.0), 8, "min"), (np.zeros((2, 3)), 4, "neither")],
)
def test_colours_part_at_zero(values, reach, extend):
    figure = figure_of(pull_picture([("waveband 1", PULL_GRID, values)]), size_px=300)
    norm = mesh_of(figure).norm
    assert type(norm).__name__ == "Normalize"
    assert (norm.vmin, norm.vmax) == (-reach, reach)
    bar = next(axes for axes in figure.axes if axes.get_label() == "colour bar")
    assert bar._colorbar.extend == extend
    assert bar.get_xlabel() == PULL.label
    figure.canvas.draw()


def test_every_zone_has_its_pull_and_a_pull_of_nothing_is_no_colour():
    figure = figure_of(pull_picture([("waveband 1", PULL_GRID, PULLS)]), size_px=300)
    shown = mesh_of(figure).get_array()[:, ::60]
    assert shown.mask.tolist() == [[False, False, False], [True, False, False]]
    assert shown[0].tolist() == PULLS[0].tolist()
    assert shown[1, 1] > 1e9  # beyond the end of the bar
    corners = mesh_of(figure).get_coordinates()
    np.testing.assert_allclose(corners[-1, 0], corners[-1, -1], atol=1e-9)  # a whole turn
    assert PULL.void in texts_of(figure)


def test_many_maps_are_spread_and_maps_without_pulls_say_so():
    picture = pull_picture([(f"waveband {k}", PULL_GRID, PULLS) for k in range(40)])
    assert len(picture.domes) == 12
    assert picture.domes[-1].title.endswith("largest pull +inf")
    assert any("12 of them" in note for note in picture.notes)
    even, dark = np.full((2, 3), 0.0049), np.full((2, 3), np.nan)
    picture = pull_picture([("waveband 1", PULL_GRID, even), ("waveband 2", PULL_GRID, dark)])
    assert [word in dome.title for word, dome in zip(("no pull", "too few"), picture.domes, strict=True)] == [True] * 2
