"""Every law has all that it needs; one that lacks something is an error in Python, in the kernels and in C."""

import dataclasses

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import CellLaw, Law
from aomc_sky.emission import band
from aomc_sky.emission.emitter import Emitter
from aomc_sky.emission.source_file import source_bytes
from aomc_sky.kernels.cells import laws as kernel_laws
from aomc_sky.plan import laws
from aomc_sky.plan.laws import beam_deg, law_of
from aomc_sky.verify.zones import choose_zones, fixed_directions, zone_shares
from tests.support.emitted import compared
from tests.support.host_scenes import WAVEBANDS, table
from tests.support.source_files import SCENES, built, needs_gcc, source_of


@pytest.mark.parametrize("law", Law)
def test_every_law_has_what_it_needs(law):
    assert law_of(law).moments
    assert (law in kernel_laws.DRAWN) == (law_of(law).directions is not None)
    assert getattr(kernel_laws, law.name, law) == law


def test_scenes_of_kernels_and_header_have_every_law():
    assert {component.law for name in SCENES for component in source_of(name, 100).components} == set(Law)


BEAMS = {
    Law.BEAM: sky.DirectBeam(sun_zenith_deg=41.0, sun_azimuth_deg=200.0),
    Law.DISC: sky.DirectBeam(sun_zenith_deg=41.0, sun_azimuth_deg=200.0, radius_deg=3.0),
    Law.DISC_AT_HORIZON: sky.DirectBeam(sun_zenith_deg=88.0, sun_azimuth_deg=200.0, radius_deg=3.0),
}


@pytest.mark.parametrize("law", Law)
def test_every_beam_says_where_it_is_and_how_wide(law):
    """Pictures, maps of radiance and the zones of `verify` ask this alone: no list of them names the laws of beams."""
    assert law_of(law).is_beam == (law in BEAMS)
    if law not in BEAMS:
        return
    (component,) = BEAMS[law].lower([550.0])
    assert component.law is law
    zenith, azimuth, radius = beam_deg(component)
    assert (zenith, azimuth, radius) == pytest.approx(
        (BEAMS[law].sun_zenith_deg, 200.0, BEAMS[law].radius_deg), abs=1e-9
    )
    source = sky.Scene(wavebands=[550.0], n_photons=2000, components=(component,)).source(precision="float64")
    to_sky = -source.photons().directions
    sine, (sin_a, cos_a) = np.sin(np.deg2rad(zenith)), (f(np.deg2rad(azimuth)) for f in (np.sin, np.cos))
    centre = np.array([sine * cos_a, sine * sin_a, np.cos(np.deg2rad(zenith))])
    away = np.rad2deg(2.0 * np.arcsin(np.linalg.norm(to_sky - centre, axis=1) / 2.0))
    assert 0.99 * radius <= away.max() <= radius + 1e-9
    fixed = fixed_directions((component,), is_centred=False)
    assert fixed[:, 0].min() <= max(zenith - radius, 0.0)
    assert fixed[:, 1].max() >= min(zenith + radius, 90.0)
    zones = choose_zones(source)
    assert zone_shares(source, zones).share.sum() == 1.0


@pytest.mark.parametrize(("zenith_deg", "radius_deg"), [(89.9, 0.27), (90.0, 3.0), (86.0, 4.5)])
def test_moments_of_a_disc_at_the_horizon_are_those_of_its_circles(zenith_deg, radius_deg):
    """Along circles round the centre mu is a + b cos(turn), whose powers have integrals in closed form."""
    (component,) = sky.DirectBeam(sun_zenith_deg=zenith_deg, sun_azimuth_deg=0.0, radius_deg=radius_deg).lower([550.0])
    assert component.law is Law.DISC_AT_HORIZON
    zenith, radius = np.deg2rad(zenith_deg), np.deg2rad(radius_deg) * (np.arange(20_000) + 0.5) / 20_000
    a, b = np.cos(zenith) * np.cos(radius), np.sin(zenith) * np.sin(radius)
    turn = np.arccos(np.clip(-a / b, -1.0, 1.0))
    angle = np.sum(np.sin(radius) * turn)
    flux = np.sum(np.sin(radius) * (a * turn + b * np.sin(turn)))
    square = (a * a + b * b / 2) * turn + 2 * a * b * np.sin(turn) + b * b * np.sin(2 * turn) / 4
    mean, inverse = law_of(component.law).moments(component)
    assert mean == pytest.approx(np.sum(np.sin(radius) * square) / flux, rel=1e-5)
    assert inverse == pytest.approx(angle / flux, rel=1e-5)


MOMENTS = law_of(Law.CELL_MU).moments
WHOLE = CellLaw(moments=MOMENTS, directions=kernel_laws.in_mu)
DRAWN = tuple(kernel_laws.DRAWN)
NEW = max(Law) + 1
LACKS = {
    "entry": (None, (*DRAWN, NEW), "add its entry"),
    "directions": (CellLaw(moments=MOMENTS), (*DRAWN, NEW), "add directions"),
    "directions of another": (CellLaw(moments=MOMENTS, starts_as=Law.HG), (*DRAWN, NEW), "add its number"),
    "number in the kernels": (WHOLE, DRAWN, "add its number"),
}


@pytest.fixture
def give(monkeypatch):
    """Makes a new member of `Law` with an entry and numbers that kernels draw; gives a plan of a table of this law."""
    new = int.__new__(Law, NEW)
    new._name_, new._value_ = "NEW", NEW
    monkeypatch.setitem(Law._member_map_, "NEW", new)
    monkeypatch.setitem(Law._value2member_map_, NEW, new)
    monkeypatch.setattr(Law, "_member_names_", [*Law._member_names_, "NEW"])

    def give_it(entry, drawn):
        monkeypatch.setitem(laws._LAWS, new, entry)
        for room in (laws, band):
            monkeypatch.setattr(room, "DRAWN", drawn)
        law_of.cache_clear()
        one = dataclasses.replace(table(Law.CELL_MU, 7, 11), law=new)
        return sky.Scene(wavebands=WAVEBANDS, n_photons=5000, components=(one,)).source().plan

    yield give_it
    law_of.cache_clear()


@pytest.mark.parametrize("lacks", LACKS)
def test_a_new_law_that_lacks_something_is_an_error(lacks, give, tmp_path):
    entry, drawn, words = LACKS[lacks]
    plan = give(WHOLE, (*DRAWN, NEW))
    plan.save(tmp_path / "plan.npz")
    batch = {name: np.empty(9, np.float32) for name in ("ux", "uy", "uz")} | {"patch": np.empty(9, np.int32)}
    for use in (
        lambda: give(entry, drawn),
        lambda: sky.Plan.load(tmp_path / "plan.npz"),
        lambda: Emitter(plan).fill_plain(0, 0, batch),
        lambda: Emitter(plan).fill_compiled(0, 0, batch),
        lambda: source_bytes(Emitter(plan)),
    ):
        with pytest.raises(NotImplementedError, match=words):
            use()


@needs_gcc
def test_a_new_law_whose_formula_kernels_and_header_lack_is_found(give):
    source = sky.PhotonSource(give(WHOLE, (*DRAWN, NEW)))
    with pytest.raises(AssertionError, match="not equal"):
        compared(source, 0, 5000)
    driver = built()
    assert driver.message(driver.view(source.to_bytes())) == "a number in a table of the file is out of its bounds"


@pytest.mark.parametrize("number", sorted({*range(-1, NEW + 1), 127} - {*DRAWN}))
def test_kernels_are_not_prepared_for_a_number_that_they_do_not_draw(number):
    emitter = Emitter(source_of("table", 100).plan)
    emitter.__dict__["_start_law"] = np.full(emitter.plan.n_cells, number, np.int8)
    with pytest.raises(NotImplementedError, match=rf"no kernel draws the laws \{{{number}\}}"):
        emitter._packed(0)
