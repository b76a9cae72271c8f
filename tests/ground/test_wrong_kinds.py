"""Arguments of the wrong kind: an AomcSkyError or Python's TypeError, an IndexError for what does not exist."""

import dataclasses
import inspect
import itertools
import warnings

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.public_names import public_names
from tests.support.signatures import public

GRID = sky.PatchGrid.regular(4, 8)
TABLE = sky.TabulatedSky(wavelength_nm=[450.0, 550.0], values=np.ones((2, 32)), grid=GRID, weighting="projected")
SCENE = sky.Scene(wavebands=[450.0, 550.0], n_photons=1000, components=TABLE)
SOURCE = SCENE.source(seed=1)
PLAN = SOURCE.plan

NONSENSE = {
    "weights": lambda: SCENE.source(weights="no"),
    "max_memory_bytes": lambda: SCENE.source(max_memory_bytes=-1),
    "per_solid_angle": lambda: sky.UniformSky(per_solid_angle="no"),
    "wavelength": lambda: sky.Wavebands([1e308]),
    "notes": lambda: dataclasses.replace(SCENE, notes="abc"),
    "notes of numbers": lambda: dataclasses.replace(SCENE, notes=(1,)),
    "bias": lambda: dataclasses.replace(SCENE, bias="x"),
    "options": lambda: dataclasses.replace(SCENE, options="x"),
    "footprint": lambda: dataclasses.replace(SCENE, footprint="circle"),
    "preset": lambda: dataclasses.replace(SCENE, preset="aomc"),
    "irradiance": lambda: dataclasses.replace(SCENE, irradiance=np.ones((2, 1))),
    "source of a path": lambda: sky.PhotonSource("plan.npz"),
    "no path": lambda: sky.files.read_mcpl(""),
    "plan of a number": lambda: sky.Plan.load(5),
    "patch of text": lambda: GRID.index_of("x"),
    "patch of a float": lambda: GRID.index_of(1.5),
}
OUTSIDE = {
    "cell moments": lambda: SOURCE.cell_moments(99),
    "mass": lambda: PLAN.mass(-1),
    "launch": lambda: PLAN.launch(-1),
    "stokes": lambda: PLAN.stokes(2),
    "index of a patch": lambda: GRID.index_of(360),
    "index of patches": lambda: GRID.index_of(np.array([0, -1])),
}


@pytest.mark.parametrize("name", NONSENSE)
def test_nonsense_is_refused(name):
    if name == "no path":
        pytest.importorskip("mcpl")
    with pytest.raises((sky.AomcSkyError, TypeError)):
        NONSENSE[name]()


@pytest.mark.parametrize("name", OUTSIDE)
def test_an_index_outside_is_an_index_error(name):
    with pytest.raises(IndexError, match="run from 0 to"):
        OUTSIDE[name]()


def test_what_fits_is_taken():
    ring, column = GRID.index_of(np.array([0, 31], np.uint8))
    assert (ring.tolist(), column.tolist()) == ([1, 4], [0, 7])
    assert [one.tolist() for one in GRID.index_of([])] == [[], []]
    assert SCENE.source(weights=np.True_, max_memory_bytes=1e9).n_bands == 2
    assert sky.Wavebands([1e9]).n_bands == 1


WRONG = (object(), "abc", -1, 1.5, {}, [], b"x", [None])
PUBLIC = {name: thing for name, thing in public().items() if name in public_names()}
CLASSES = {name: thing for name, thing in PUBLIC.items() if isinstance(thing, type)}
SUN = {"sun_zenith_deg": 40.0, "sun_azimuth_deg": 10.0}
LOBE = {"name": "town", "kind": "hg", "param0": 0.8, "param1": 0.0, "quaternion": np.array([1.0, 0.0, 0.0, 0.0])}
LOBES = sky.LobeSky(lobes=(sky.lobes.WeightedLobe(**LOBE, wavelength_nm=np.array([550.0]), spectrum=np.array([1e-8])),))
INSTANCES = {
    "CIESky": lambda: sky.CIESky(type=12, **SUN),
    "CardioidalSky": sky.CardioidalSky,
    "ClearSky": sky.ClearSky,
    "component.Component": lambda: PLAN.components[0],
    "DirectBeam": lambda: sky.DirectBeam(**SUN),
    "FunctionSky": lambda: sky.FunctionSky(lambda zenith, azimuth, nm: np.cos(zenith), grid=GRID),
    "HarrisonCoombesSky": lambda: sky.HarrisonCoombesSky(**SUN),
    "LobeSky": lambda: LOBES,
    "OvercastSky": sky.OvercastSky,
    "PatchGrid": lambda: GRID,
    "PerezSky": lambda: sky.PerezSky(**SUN, epsilon=3.0, delta=0.1, grid=GRID),
    "PhotonBatch": SOURCE.photons,
    "PhotonSource": lambda: SOURCE,
    "Plan": lambda: PLAN,
    "RayleighPattern": sky.RayleighPattern,
    "Scene": lambda: SCENE,
    "TabulatedSky": lambda: TABLE,
    "UniformSky": sky.UniformSky,
    "lobes.WeightedLobe": lambda: LOBES.lobes[0],
}
"""One of each class with methods."""

WITHOUT = {"AtmosphereSky", "lobes.BackgroundSky", "atmosphere.Moon", "RadianceField"}
"""Classes whose objects take seconds or a file; their methods have the arguments of the others."""

OF_CLASSES = {name: thing for name, thing in public().items() if name.rpartition(".")[0] in CLASSES}
MAKERS = {name: thing for name, thing in OF_CLASSES.items() if isinstance(getattr(thing, "__self__", None), type)}
METHODS = sorted(set(OF_CLASSES) - set(MAKERS))


def test_every_class_with_methods_has_an_object():
    assert {name.rpartition(".")[0] for name in METHODS} == set(INSTANCES) | WITHOUT


def calls(function):
    """Arguments that are all of a wrong kind: those that must be given, and each other one beside them."""
    kinds = inspect.Parameter
    given = [one for one in inspect.signature(function).parameters.values() if one.kind not in _VARIABLE]
    required = [one for one in given if one.default is one.empty]
    for wrong, more in itertools.product(WRONG, [None, *(one for one in given if one.default is not one.empty)]):
        named = {one.name: wrong for one in (*required, more) if one is not None and one.kind is kinds.KEYWORD_ONLY}
        placed = [wrong for one in required if one.kind is not kinds.KEYWORD_ONLY]
        yield placed, named if more is None else {**named, more.name: wrong}


_VARIABLE = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


@pytest.mark.parametrize("name", sorted({*PUBLIC, *OF_CLASSES}))
def test_wrong_kinds_are_refused_by_the_rule(name, tmp_path, monkeypatch):
    """What happens to be right may pass."""
    monkeypatch.chdir(tmp_path)
    owner, _, method = name.rpartition(".")
    if name in METHODS and owner in WITHOUT:
        pytest.skip("its objects take seconds")
    function = getattr(INSTANCES[owner](), method) if name in METHODS else {**PUBLIC, **MAKERS}[name]
    for placed, named in calls(function):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                function(*placed, **named)
            except (sky.AomcSkyError, TypeError, IndexError):
                pass
            except Exception as error:
                pytest.fail(f"{name}(*{placed}, **{named}) gives {error!r}")
