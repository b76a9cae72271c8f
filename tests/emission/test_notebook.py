"""What a notebook shows of scenes, sources and photons."""

import base64
import re

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import MissingExtraError

OVERCAST = sky.OvercastSky(irradiance_W_m2_nm=[0.3, 0.2])
SCENE = sky.Scene(wavebands=[440, 550], n_photons=[1000, 2000], components=OVERCAST)


def png_of(html):
    (data,) = re.findall(r'<img alt="the dome of the sky" src="data:image/png;base64,([^"]+)">', html)
    return base64.b64decode(data)


def test_a_table_and_the_dome():
    pytest.importorskip("matplotlib")
    source = SCENE.source()
    batch = source.photons(1)
    shown = [one._repr_html_() for one in (SCENE, source, batch, batch[:0])]
    assert "<td>550</td><td>2000</td><td>0.2</td>" in shown[0]
    assert f"<td>2000</td><td>{source.exact_moments(1).mean_mu:.6f}</td>" in shown[1]
    assert f"<td>0</td><td>{batch.ux[0]:.6g}</td>" in shown[2]
    assert "... 2000 in all" in shown[2]
    for html in shown[:3]:
        assert png_of(html).startswith(b"\x89PNG")
    assert len({*shown}) == 4


def test_without_matplotlib_it_says_what_to_install(monkeypatch):
    def missing(*_, **__):
        raise MissingExtraError('pip install ".[plot]"')

    monkeypatch.setattr(sky, "plot", missing)
    html = SCENE._repr_html_()
    assert "pip install" in html
    assert "<td>440</td>" in html
    assert "<img" not in html


def test_scene_plot_is_plot(tmp_path):
    pytest.importorskip("matplotlib")
    SCENE.plot(tmp_path / "a.png", bands=[1], size_px=400)
    sky.plot(SCENE, tmp_path / "b.png", bands=[1], size_px=400)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_photons_one_by_one():
    day = {"wavebands": [440, 550, 670], "n_photons": [300, 100, 0], "components": "overcast"}
    source = sky.Scene(**day, footprint=sky.Footprint.circle(2.0)).source(seed=4)
    photons = list(source.one_by_one())
    assert len(photons) == 400
    for n in range(1, 401):  # every first part holds the wavebands in their shares
        assert abs(sum(p.band == 1 for p in photons[:n]) - n / 4) < 1
    for band in (0, 1):
        batch = source.photons(band)
        band_photons = [p for p in photons if p.band == band]
        assert [p.index_in_band for p in band_photons] == list(range(len(batch)))
        for name in ("ux", "uy", "uz", "x", "y"):
            np.testing.assert_array_equal([getattr(p, name) for p in band_photons], getattr(batch, name))
    assert {p.weight for p in photons} == {1.0}
    plain = next(sky.Scene(wavebands=[440], n_photons=1, components="uniform").source().one_by_one())
    assert (plain.x, plain.y, plain.wavelength_nm) == (0.0, 0.0, 440.0)


def test_footprints_by_name():
    circle = sky.Footprint(shape=sky.plan.options.FootprintShape.CIRCLE, size_x_m=2.0, size_y_m=2.0)
    assert sky.Footprint.circle(2.0) == circle == sky.Footprint(shape="circle", size_x_m=2.0, size_y_m=2.0)
    assert sky.Footprint.rectangle(1.0, 3.0).shape is sky.plan.options.FootprintShape.RECTANGLE
