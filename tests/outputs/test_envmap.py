"""Maps of radiance as pictures: what independent readers of the two formats find in them."""

import re
import struct
import subprocess
import sys

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.outputs.envmap import N_COLUMNS, N_ROWS, RGBE_ERROR, axes_of, map_bytes, map_file, maps, n_parts

ORDERS = {"grey": [1], "colours": [1, 2, 0]}  # wavebands of 700, 450 and 550 nm, as they are asked for
RED_FIRST = {"grey": [1], "colours": [0, 2, 1]}


def coloured(zenith, azimuth, wavelength_nm):
    """Up to 10^5 times as bright, elsewhere in each colour; dark in a part of the sky."""
    bright = 10.0 ** (3 + 2 * np.cos(azimuth - wavelength_nm / 100)) * np.cos(zenith)
    return np.where(np.cos(3 * azimuth) > -0.9, bright, 0.0) + 0 * wavelength_nm


@pytest.fixture(scope="module")
def source():
    model = sky.FunctionSky(coloured, grid=sky.PatchGrid.regular(18, 72))
    return sky.Scene(wavebands=[700.0, 450.0, 550.0], n_photons=1000, components=model).source()


def picture(source, bands, name):
    head, size = map_file(source, bands, name)
    parts = list(map_bytes(source, bands, name))
    data = head + b"".join(parts)
    assert len(data) == size
    assert len(parts) == n_parts(name, len(bands))
    return data


def expected(source, bands):
    """Radiance of each colour in a picture: column 0 begins in the west (180 degrees), and azimuths fall."""
    falling = (N_COLUMNS // 2 - 1 - np.arange(N_COLUMNS)) % N_COLUMNS
    return np.stack([one[:, falling] for one in maps(source, bands)], axis=-1).astype(float)


def read_as_radiance(data):
    """Radiance's colr_color: (mantissa + 1/2) x 2^(exponent - 136); all 0 where the exponent is 0."""
    head, rows, columns, pixels = re.fullmatch(rb"#\?RADIANCE\n(.*)\n\n-Y (\d+) \+X (\d+)\n(.*)", data, re.S).groups()
    assert b"FORMAT=32-bit_rle_rgbe" in head.split(b"\n")
    rgbe = np.frombuffer(pixels, np.uint8).reshape(int(rows), int(columns), 4).astype(float)
    first = np.frombuffer(pixels, np.uint8).reshape(-1, 4)
    is_rle = (first[:, :2] == 2).all(axis=1) & (first[:, 2] < 128)
    assert not is_rle.any()  # of the first pixel of a line: the mark of run-length coding
    return np.where(rgbe[..., 3:] > 0, (rgbe[..., :3] + 0.5) * 2.0 ** (rgbe[..., 3:] - 136), 0.0)


def read_exr(data):
    """Channels by the page "OpenEXR file layout", for float32 without compression."""
    assert struct.unpack_from("<2i", data) == (20000630, 2)
    at, attributes = 8, {}
    while data[at]:
        name, kind = data[at : at + 60].split(b"\0")[:2]
        at += len(name) + len(kind) + 2
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name.decode()] = data[at + 4 : at + 4 + size]
        at += 4 + size
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    assert attributes["compression"] == attributes["lineOrder"] == b"\0"
    listed, names = attributes["channels"], []
    while listed != b"\0":
        name, _, listed = listed.partition(b"\0")
        assert struct.unpack_from("<iB3xii", listed) == (2, 0, 1, 1)
        names, listed = [*names, name.decode()], listed[16:]
    assert names == sorted(names)
    channels = {name: np.zeros((y1 - y0 + 1, x1 - x0 + 1), np.float32) for name in names}
    for place in struct.unpack_from(f"<{y1 - y0 + 1}Q", data, at + 1):
        y, size = struct.unpack_from("<2i", data, place)
        row = np.frombuffer(data, "<f4", size // 4, place + 8).reshape(len(names), -1)
        for name, values in zip(names, row, strict=True):
            channels[name][y] = values
    return channels


@pytest.mark.parametrize("which", ORDERS)
def test_radiance_reads_an_hdr_picture_within_its_bound(source, which):
    """The cut value is in the middle of its step: half a step is 2^-9, of a largest mantissa of at least 1/2."""
    found = read_as_radiance(picture(source, ORDERS[which], "sky.hdr"))
    true = expected(source, RED_FIRST[which])
    true = np.broadcast_to(true, found.shape)
    largest = true.max(axis=-1, keepdims=True)
    assert largest.max() / largest[largest > 0].min() > 1e4
    assert np.all(found[largest[..., 0] == 0] == 0)
    lit = largest > 0
    error = np.abs(found - true)[lit[..., 0]] / largest[lit[..., 0]]
    assert error.max() <= RGBE_ERROR
    assert error.max() > 0.9 * RGBE_ERROR  # the bound is not an idle one
    mirrored = true[:, ::-1]  # planted: what a map in the order of the array gives
    assert np.abs(found - mirrored)[lit[..., 0]].max() > 0.1 * largest.max()


@pytest.mark.parametrize("which", ORDERS)
def test_an_exr_picture_is_exact(source, which):
    channels = read_exr(picture(source, ORDERS[which], "SKY.EXR"))
    names = {"grey": "Y", "colours": "RGB"}[which]
    assert set(channels) == set(names)
    np.testing.assert_array_equal(np.stack([channels[name] for name in names], -1), expected(source, RED_FIRST[which]))


MITSUBA = """
import sys
import mitsuba
import numpy as np
mitsuba.set_variant("scalar_rgb")
for path in sys.argv[1:]:
    np.save(path + ".npy", np.array(mitsuba.Bitmap(path)))
"""
ENDINGS = ("hdr", "exr")


@pytest.fixture(scope="module")
def read_by_mitsuba(source, tmp_path_factory):
    """Pixels of all pictures, read in a process of its own: behind many other tests Mitsuba waits for ever here."""
    pytest.importorskip("mitsuba")
    folder = tmp_path_factory.mktemp("pictures")
    names = [f"{which}.{ending}" for which in ORDERS for ending in ENDINGS]
    for name in names:
        (folder / name).write_bytes(picture(source, ORDERS[name.partition(".")[0]], name))
    subprocess.run([sys.executable, "-c", MITSUBA, *names], cwd=folder, check=True, timeout=300)
    return {name: np.load(folder / f"{name}.npy").reshape(N_ROWS, N_COLUMNS, -1) for name in names}


@pytest.mark.parametrize("which", ORDERS)
@pytest.mark.parametrize("ending", ENDINGS)
def test_mitsuba_reads_pictures(source, read_by_mitsuba, which, ending):
    """Mitsuba has no half in an .hdr pixel: its values are up to 2^-7 of the largest lower."""
    found = read_by_mitsuba[f"{which}.{ending}"]
    true = expected(source, RED_FIRST[which])
    if ending == "exr":
        np.testing.assert_array_equal(found, true)
    else:
        largest = true.max(axis=-1, keepdims=True)
        assert np.all(found <= true)
        assert np.all(true - found <= 2 * RGBE_ERROR * largest)


def test_the_meaning_of_a_picture(source):
    axes = axes_of(source, ORDERS["colours"], "sky.hdr")
    assert axes["channels_nm"] == {"red": 700.0, "green": 550.0, "blue": 450.0}
    assert axes["wavelength_nm"] == [450.0, 550.0, 700.0]
    assert [axes["azimuth_deg"][key] for key in ("first_edge", "step", "n")] == [180.0, -0.5, 720]
    assert axes_of(source, [1], "sky.exr")["channels_nm"] == {"grey": 450.0}
    assert "channels_nm" not in axes_of(source, [1], "sky.npy")


def test_what_a_picture_cannot_hold(source):
    with pytest.raises(sky.UsageError, match=r"sky\.hdr is a picture.*there are 2: add --waveband I"):
        list(map_bytes(source, [0, 1], "sky.hdr"))
    bright = sky.FunctionSky(lambda z, a, nm: 1 + 0 * z, irradiance_W_m2_nm=[1e38 * np.pi * 1.75])
    with pytest.warns(sky.InputWarning, match=r"W m-2 nm-1 on the horizontal plane, 3e\+38 times the sun"):
        bright = sky.Scene(wavebands=[550.0], n_photons=10, components=bright).source()
    with pytest.raises(sky.SceneError, match=r"write a \.exr file"):
        list(map_bytes(bright, [0], "sky.hdr"))
    assert np.isfinite(read_exr(picture(bright, [0], "sky.exr"))["Y"]).all()
