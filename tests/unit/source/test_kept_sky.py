"""A sky from the cache is the one that a new solution gives, to the bit; anything else on the disk is solved anew."""

import dataclasses
import hashlib
import json
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

from aomc_sky.atmosphere.lights import Moon
from aomc_sky.atmosphere.medium import contents
from aomc_sky.cache import Cache, DamagedEntryError
from aomc_sky.errors import CacheWarning, InputWarning, ModelLimitWarning
from aomc_sky.formats.atmo.reader import read_atmo
from aomc_sky.grid import PatchGrid
from aomc_sky.skies import atmosphere as sky_model
from aomc_sky.source.atmospheres import kept_sky as kept
from aomc_sky.source.atmospheres.kept_sky import kept_sky
from aomc_sky.source.atmospheres.medium import read_medium
from tests.support import atmospheres
from tests.support.atmospheres import counted_solutions

INPUTS = Path(__file__).parents[3] / "inputs"
GRID = PatchGrid.regular(4, 6)
MOON = Moon(zenith_rad=np.radians(55.04), azimuth_from_sun_rad=np.radians(0.05), distance_m=3.6e8)
SKIES = {
    "high sun": {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 30.0},
    "one order": {"sun_zenith_deg": 40.0, "n_orders": 1},
    "twilight": {"sun_zenith_deg": 93.0, "n_paths": 16},
    "eclipse": {"sun_zenith_deg": 55.0, "moon": MOON, "n_paths": 16},
    "the Moon elsewhere": {"sun_zenith_deg": 20.0, "moon": MOON, "n_orders": 1},
    "glowing ground": {"sun_zenith_deg": 130.0, "ground_radiance": np.array([1e-6, 2e-6]), "n_paths": 16},
    "sun and glow": {"sun_zenith_deg": 60.0, "ground_radiance": np.array([1e-6, 2e-6]), "n_paths": 16},
}


@pytest.fixture(scope="module")
def medium():
    return read_medium(read_atmo(INPUTS / "twilight" / "air.atmo"))[0]


@pytest.fixture
def cache(tmp_path):
    return Cache(folder=tmp_path)


@pytest.fixture
def solutions(monkeypatch):
    return counted_solutions(monkeypatch)


def heard(*arguments, **named):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sky = kept_sky(*arguments, **named)
    return sky, [(one.category, str(one.message)) for one in caught]


def assert_equal(found, fresh):
    """Every number of two skies is the same to the bit, whatever holds it."""
    for name in ("patch_mean", "patch_change", "diffuse_irradiance", "direct_irradiance", "patch_error"):
        np.testing.assert_array_equal(getattr(found, name), getattr(fresh, name), name)
    for one in dataclasses.fields(fresh.solved):
        if one.name not in ("seconds", "medium", "once", "more", "glow", "direct"):
            np.testing.assert_array_equal(getattr(found.solved, one.name), getattr(fresh.solved, one.name), one.name)
    for name in ("optical_depth", "irradiance", "sun_zenith_rad", "sun_angular_radius_rad"):
        np.testing.assert_array_equal(getattr(found.solved.direct, name), getattr(fresh.solved.direct, name))
    zenith, azimuth = np.radians([0.0, 20.0, 50.0, 89.0]), np.radians([0.0, 40.0, 200.0, 300.0])
    np.testing.assert_array_equal(found.solved.at(zenith, azimuth), fresh.solved.at(zenith, azimuth))
    np.testing.assert_array_equal(found.radiance(zenith, azimuth, 450.0), fresh.radiance(zenith, azimuth, 450.0))
    assert found.n_listed == fresh.n_listed
    assert type(found.solved.once) is type(fresh.solved.once)


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n == "eclipse")) for n in SKIES])
def test_the_second_time_gives_the_bits_and_the_warnings_of_the_first(name, medium, cache, solutions):
    first, of_first = heard(cache, medium=medium, grid=GRID, **SKIES[name])
    assert first.solved is solutions[0]
    assert len(list(cache.folder.iterdir())) == 1
    second, of_second = heard(cache, medium=medium, grid=GRID, **SKIES[name])
    assert len(solutions) == 1
    assert_equal(second, first)
    assert of_first == of_second
    assert list(second.solved.seconds) == ["cache"]


def test_without_a_cache_the_sky_is_the_same(medium, cache, solutions):
    (without, of_without), (first, of_first) = (
        heard(c, medium=medium, grid=GRID, **SKIES["sun and glow"]) for c in (None, cache)
    )
    assert len(solutions) == 2
    assert_equal(first, without)
    assert of_without == of_first


def test_a_warning_of_the_model_is_repeated(medium, cache):
    args = {"medium": medium, "grid": GRID, "sun_zenith_deg": 85.0, "method": "sos", "n_orders": 2}
    _, first = heard(cache, **args)
    _, second = heard(cache, **args)
    assert first == second
    assert first[0][0] is ModelLimitWarning
    assert len(first) == 1


def test_a_strict_command_stops_at_a_warning_that_was_kept(medium, cache):
    args = {"medium": medium, "grid": GRID, "sun_zenith_deg": 85.0, "method": "sos", "n_orders": 2}
    heard(cache, **args)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ModelLimitWarning)
        with pytest.raises(ModelLimitWarning):
            kept_sky(cache, **args)


def test_a_warning_of_others_is_passed_on_and_nothing_is_kept(medium, cache, monkeypatch):
    def loud(*arguments, **named):
        warnings.warn("of numpy", RuntimeWarning, stacklevel=1)
        return sky_model.AtmosphereSky(*arguments, **named)

    monkeypatch.setattr(kept, "AtmosphereSky", loud)
    _, told = heard(cache, medium=medium, grid=GRID, sun_zenith_deg=40.0, n_orders=1)
    assert told == [(RuntimeWarning, "of numpy")]
    assert not list(cache.folder.iterdir())


def changed(medium, **values):
    return dataclasses.replace(medium, **values)


def with_density(medium, text):
    """The medium with another text in the block of its first density."""
    first, *others = medium.constituents
    block = first.number_density.block
    source = dataclasses.replace(block.source, text=text)
    density = dataclasses.replace(first.number_density, block=dataclasses.replace(block, source=source))
    return changed(medium, constituents=(dataclasses.replace(first, number_density=density), *others))


DIFFERENT = {
    "sun": lambda m: (m, {"sun_zenith_deg": np.nextafter(40.0, 41.0)}),
    "azimuth of the sun": lambda m: (m, {"sun_azimuth_deg": 1.0}),
    "orders": lambda m: (m, {"n_orders": 2}),
    "method": lambda m: (m, {"method": "order1"}),
    "paths": lambda m: (m, {"n_paths": 17}),
    "patches": lambda m: (m, {"grid": PatchGrid.regular(4, 7)}),
    "Moon": lambda m: (m, {"moon": MOON}),
    "glow": lambda m: (m, {"ground_radiance": np.array([1.0, 2.0])}),
    "albedo": lambda m: (changed(m, ground_albedo=np.array([0.06, 0.04])), {}),
    "radius": lambda m: (changed(m, earth_radius_m=6.4e6), {}),
    "orders of the medium": lambda m: (changed(m, n_orders=15), {}),
    "angles": lambda m: (changed(m, least_angles=3), {}),
    "constituents": lambda m: (changed(m, constituents=m.constituents[:2]), {}),
    "text of a block": lambda m: (with_density(m, "\n return 2.547e25 * exp(-altitude / (8.436*km));\n"), {}),
}


@pytest.mark.parametrize("name", DIFFERENT)
def test_whatever_changes_the_light_changes_the_key(name, medium):
    usual = {"grid": GRID, "sun_zenith_deg": 40.0, "sun_azimuth_deg": 0.0, "method": "auto", "n_orders": 1}
    usual |= {"moon": None, "ground_radiance": None, "n_paths": None}
    other, values = DIFFERENT[name](medium)
    assert key_of(other, usual | values) != key_of(medium, usual) == key_of(changed(medium), dict(usual))


def key_of(medium, values):
    values = dict(values)
    return kept._key(medium, values.pop("grid"), tuple(values.values()))


def test_another_version_of_the_code_another_library_or_processor_has_other_keys(medium, monkeypatch):
    keys = {kept._key(medium, GRID, ())}
    for name in ("_of_code", "_of_machine"):
        with monkeypatch.context() as patch:
            patch.setattr(kept, name, lambda name=name: ("another", name))
            keys.add(kept._key(medium, GRID, ()))
    monkeypatch.setenv("NPY_DISABLE_CPU_FEATURES", "AVX512F")
    keys.add(kept._key(medium, GRID, ()))
    assert len(keys) == 4


def test_an_entry_of_another_version_is_not_looked_at(medium, cache, solutions, monkeypatch):
    for version in ("1", "2"):
        monkeypatch.setattr(kept, "_of_code", lambda version=version: (version,))
        kept_sky(cache, medium=medium, grid=GRID, sun_zenith_deg=40.0, n_orders=1)
    assert len(solutions) == 2
    assert len(list(cache.folder.iterdir())) == 2


def test_the_text_of_the_package_and_all_libraries_are_in_the_key():
    _, text, *releases = kept._of_code()
    assert len(text) == 64
    assert [one.split("\n")[0] for one in releases] == ["numpy", "scipy", "numba", "llvmlite"]
    assert all(len(one.split("\n")) > 2 for one in releases)


def test_a_medium_of_functions_that_nobody_can_name_is_solved_each_time(cache, solutions):
    medium = atmospheres.molecules_only([450.0])
    assert contents(medium) is None
    for _ in range(2):
        kept_sky(cache, medium=medium, grid=GRID, sun_zenith_deg=40.0, n_orders=1)
    assert len(solutions) == 2
    assert not list(cache.folder.iterdir())


@pytest.fixture(scope="module")
def kept_once(medium, tmp_path_factory):
    """A solution of order 1: what it was asked for, what was found, and the folder that keeps it."""
    args, folder = (
        {"medium": medium, "grid": GRID, "sun_zenith_deg": 40.0, "n_orders": 1},
        tmp_path_factory.mktemp("kept"),
    )
    return args, heard(Cache(folder=folder), **args)[0], folder


@pytest.fixture
def entry(kept_once, cache):
    """The same in a cache of the test's own."""
    args, fresh, folder = kept_once
    shutil.copytree(folder, cache.folder, dirs_exist_ok=True)
    return args, fresh


def entry_of(cache):
    (path,) = cache.folder.glob("*.entry")
    return path


@pytest.mark.parametrize("damage", [lambda b: b[:-9], lambda b: b"", lambda b: b[:200] + b"\0" + b[201:]])
def test_a_damaged_entry_is_named_solved_anew_and_replaced(entry, cache, solutions, damage):
    args, fresh = entry
    good = entry_of(cache).read_bytes()
    entry_of(cache).write_bytes(damage(good))
    with pytest.warns(CacheWarning, match=f"{entry_of(cache)}: this kept solution"):
        again = kept_sky(cache, **args)
    assert_equal(again, fresh)
    assert len(solutions) == 1
    assert entry_of(cache).read_bytes() == good
    assert heard(cache, **args)[1] == []
    assert len(solutions) == 1


def set_about(name, value):
    def change(about, arrays):
        about[name] = value

    return change


def set_number(name, value):
    def change(about, arrays):
        arrays[name].flat[0] = value

    return change


def set_shape(name, shape):
    def change(about, arrays):
        about["arrays"][name] = shape

    return change


def without(name):
    def change(about, arrays):
        del about["arrays"][name], arrays[name]

    return change


FORGED = {
    "method": set_about("method", "magic"),
    "orders": set_about("n_orders", -1),
    "orders as text": set_about("n_orders", "2"),
    "reason": set_about("reason", ["x"]),
    "Moon": set_about("has_moon", 1),
    "warnings": set_about("warnings", [["SystemExit", "x"]]),
    "warnings without text": set_about("warnings", [["InputWarning"]]),
    "arrays": set_about("arrays", []),
    "a list of it": set_about("mirrored", None),
    "negative light": set_number("patch_mean", -1.0),
    "NaN light": set_number("patch_mean", np.nan),
    "infinite beam": set_number("irradiance", np.inf),
    "NaN depth": set_number("depth", np.nan),
    "NaN series": set_number("once", np.nan),
    "negative error": set_number("numbers", -1.0),
    "negative length": set_shape("patch_mean", [2, -1, -24]),
    "length as a float": set_shape("patch_mean", [2, 1, 24.0]),
    "huge length": set_shape("patch_mean", [2, 2**62, 2**62]),
    "two axes": set_shape("patch_mean", [48]),
    "another medium": set_shape("depth", [1]),
    "a missing array": without("patch_mean"),
    "a missing beam": without("irradiance"),
    "an unknown array": lambda about, arrays: about["arrays"].__setitem__("more_light", [0]),
}


@pytest.mark.parametrize("name", FORGED)
def test_an_entry_with_a_right_hash_and_wrong_content_is_solved_anew(name, entry, cache, solutions):
    args, fresh = entry
    key = entry_of(cache).name.removesuffix(".entry")
    head, _, body = cache.read(key).partition(b"\n")
    about, values, arrays = json.loads(head), np.frombuffer(body, "<f8"), {}
    for one, shape in about["arrays"].items():
        arrays[one], values = values[: np.prod(shape)].copy(), values[np.prod(shape) :]
    FORGED[name](about, arrays)
    cache.write(key, json.dumps(about).encode() + b"\n" + b"".join(array.tobytes() for array in arrays.values()))
    with pytest.warns(CacheWarning, match="not in the form of this version"):
        again = kept_sky(cache, **args)
    assert_equal(again, fresh)
    assert len(solutions) == 1


@pytest.mark.parametrize("content", [b"", b"\n", b"[" * 60_000, b"\xff\n", b"null\n", b"{" + b" " * 70_000 + b"}\n"])
def test_content_that_is_nothing_of_ours_is_refused(content, medium):
    with pytest.raises(DamagedEntryError):
        kept._decoded(content, medium, 40.0, None, GRID)


def test_every_category_that_is_repeated_is_one_of_the_package():
    assert set(kept._REPORTED) == {InputWarning, ModelLimitWarning}


def test_the_hash_tells_kinds_and_lengths_apart():
    def of(value):
        digest = hashlib.sha256()
        kept._add(digest, value)
        return digest.hexdigest()

    values = [
        1,
        1.0,
        "1",
        "1.0",
        None,
        "None",
        True,
        ("a", "b"),
        ("ab",),
        (("a",), "b"),
        np.array([1.0]),
        np.array([1]),
    ]
    values += [np.array([[1.0]]), 0.0, -0.0, (), "", np.array([]), np.float32(1)]
    assert len({of(value) for value in values}) == len(values)
