"""The reader of background-sky files against files of plain h5py, and the writer against plain h5py as a reader."""

import operator
import pickle
import time
from dataclasses import replace

import numpy as np
import pytest

from aomc_sky.errors import InputFileError, InputWarning, SceneError
from aomc_sky.skies.lobes.background import background_at
from aomc_sky.skies.lobes.file.data import BackgroundFile, BackgroundInfo, ReferenceType, normalised
from aomc_sky.skies.lobes.file.file import read_background_file as read
from aomc_sky.skies.lobes.file.file import write_background
from aomc_sky.skies.lobes.light import background_sky
from tests.skies.lobes.animations import animation
from tests.support.background import CURVES, SAMPLES, lobe_dtype, plain_file

h5py = pytest.importorskip("h5py")
GZIP = {"chunks": True, "compression": "gzip", "shuffle": True, "fletcher32": True}
SHAPES = {
    "as the format has it": {},
    "big endian": {"dtype": lobe_dtype(">"), "spectrum": ">f4"},
    "wide": {"dtype": lobe_dtype(real="f8", integer="i8"), "spectrum": "<f8"},
    "narrow": {"dtype": lobe_dtype(">", integer="u1")},
    "padded": {"dtype": lobe_dtype(padding=3)},
    "reversed": {"dtype": lobe_dtype(reverse=True, padding=1)},
    "chunked": {"chunks": True},
    "gzip": GZIP,
    "checked": {"fletcher32": True},
    "extendible": {"maxshape": None, "chunks": True},
    "latest": {"libver": "latest"},
    "latest gzip": {"libver": "latest", **GZIP},
    "attributes": {"info": "attributes"},
    "fixed texts": {"info": "fixed"},
    "flat samples": {"samples": SAMPLES},
}


def codes(error):
    return [p.code for p in error.value.problems]


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_every_shape_of_the_same_content_is_the_same(shape, tmp_path):
    file = read(plain_file(tmp_path / "x.h5", **shape))
    assert file.info == BackgroundInfo(name="sky", author="Grüße", organization="none", file_type=5, format_version=1)
    wide = np.float64 if shape.get("spectrum") == "<f8" else np.float32
    assert file.wavelength_nm.tolist() == [500.0, 625.0, 750.0]
    assert np.array_equal(file.curves, np.array(CURVES, wide).astype(np.float64) * 10)
    (keys,) = file.animations.values()
    assert keys.lobe_type.tolist() == [1, 2, 3]
    assert keys.param0.tolist() == [0.5, 0.25, 0.375]
    assert keys.param1.tolist() == [0.0, 1.5, 2.0]  # none for Henyey-Greenstein
    assert keys.coefficient.tolist() == [0.25, 1.0, 0.0]
    assert keys.quaternion.tolist() == [[1, 0, 0, 0], [0.5, -0.5, 0.5, 0.5], [0, 0, 0, -1]]
    assert keys.curve_index.tolist() == [1, 0, 1]
    assert keys.relative_time_days.tolist() == [0.0, 0.25, 1.0]
    assert keys.reference is ReferenceType.DIURNAL
    assert keys.time_point_s == 0
    assert len(keys) == 3


def test_arrays_are_read_only_and_the_file_travels(tmp_path):
    file = read(plain_file(tmp_path / "x.h5"))
    with pytest.raises(ValueError, match="read-only"):
        file.curves[0, 0] = 1
    with pytest.raises(ValueError, match="read-only"):
        file.animations["a"].quaternion[0] = 1
    again = pickle.loads(pickle.dumps(file))
    assert again.animations["a"].reference is ReferenceType.DIURNAL
    assert np.array_equal(again.curves, file.curves)
    lobe = (1, 0.0, 0.0, 1.0, (1, 0, 0, 0), 0, -3.5)
    file = read(plain_file(tmp_path / "x.h5", lobes=[lobe], curves=CURVES[0], reference=(1, 2**63 + 5)))
    assert file.curves.shape == (1, 3)
    assert (file.animations["a"].time_point_s, *file.animations["a"].relative_time_days) == (2**63 + 5, -3.5)
    lobes = [(1, 0.0, 0.0, 1.0, np.array([3, -4, 0, 12]) * s, 0, 0.0) for s in (1e-40, 1e-20, 1.0, 1e20, 1e37)]
    quaternion = read(plain_file(tmp_path / "x.h5", lobes=lobes)).animations["a"].quaternion
    assert np.allclose(quaternion[1:], np.array([3, -4, 0, 12]) / 13, rtol=1e-7, atol=0)
    assert np.abs(np.sqrt((quaternion**2).sum(axis=1)) - 1).max() < 4e-16


def test_what_is_a_warning(tmp_path):
    with pytest.warns(InputWarning) as caught:
        file = read(plain_file(tmp_path / "x.h5", info="none"))
    assert len(caught) == 4  # author, name, type and version
    assert file.info == BackgroundInfo()
    with pytest.warns(InputWarning, match=r"warning\[E506\]: /SpectralSamples: .* 400 micrometres"):
        assert read(plain_file(tmp_path / "x.h5", samples=((400.0, 500.0, 600.0),))).wavelength_nm[0] == 4e5


def lobe(**changes):
    names = ("kind", "param0", "param1", "coeff", "quaternion", "curve", "time")
    values = dict(zip(names, (2, 0.25, 1.5, 1.0, (1, 0, 0, 0), 0, 0.5), strict=True)) | changes
    return tuple(values[n] for n in names)


BAD_LOBES = {
    "type 0": (lobe(kind=0), "E506", "Type"),
    "type 257": (lobe(kind=257), "E506", "Type"),  # 1 in eight bits
    "g nan": (lobe(kind=1, param0=np.nan), "E506", "Param0"),
    "g 1": (lobe(kind=1, param0=0.999999999), "E506", "Param0"),  # in 32 bits
    "g negative": (lobe(kind=1, param0=-0.5), "E506", "Param0"),
    "alpha 0": (lobe(param0=0.0), "E506", "Param0"),
    "alpha negative": (lobe(param1=-1.0), "E506", "Param1"),
    "coefficient negative": (lobe(coeff=-1e-30), "E506", "Coeff"),
    "quaternion inf": (lobe(quaternion=(1, 0, 0, np.inf)), "E506", "LocalTransform"),
    "curve 2": (lobe(curve=2), "E508", "CurveIndex"),
    "time beyond the day": (lobe(time=1.0001), "E507", "RelativeTime"),
    "time negative": (lobe(time=-1e-3), "E507", "RelativeTime"),
}


@pytest.mark.parametrize(("bad", "code", "name"), BAD_LOBES.values(), ids=BAD_LOBES)
def test_a_value_outside_its_range_is_named(bad, code, name, tmp_path):
    with pytest.raises(InputFileError, match=rf"Lobes: {name} \[1\] is .*allowed") as error:
        read(plain_file(tmp_path / "x.h5", lobes=[lobe(time=0.0), bad, *[lobe(time=1.0)] * 2]))
    assert codes(error) == [code]


def test_times_may_be_equal_but_never_fall(tmp_path):
    times = (0.0, 0.5, 0.5, 1.0)
    assert len(read(plain_file(tmp_path / "x.h5", lobes=[lobe(time=t) for t in times])).animations["a"]) == 4
    with pytest.raises(InputFileError, match=r"E507.*RelativeTime \[1\] is 0.25"):
        read(plain_file(tmp_path / "y.h5", lobes=[lobe(time=t) for t in (0.5, 0.25, 1.0)]))
    plain_file(tmp_path / "week.h5", lobes=[lobe(time=7.0)], reference=(3, 0))
    assert read(tmp_path / "week.h5").animations["a"].relative_time_days.tolist() == [7.0]
    with pytest.raises(InputFileError, match="0 to 7"):
        read(plain_file(tmp_path / "z.h5", lobes=[lobe(time=7.01)], reference=(3, 0)))


BAD_FILES = {
    "reference type": ({"reference": (4, 0)}, "E506"),
    "wavelength twice": ({"samples": ((0.5, 0.5, 0.75),)}, "E507"),
    "wavelength 0": ({"samples": ((0.0, 0.5, 0.75),)}, "E506"),
    "curve inf": ({"curves": ((1.0, np.inf, 1.0), (1, 1, 1))}, "E506"),
    "no curve": ({"curves": np.zeros((0, 3))}, "E505"),
    "two samples": ({"samples": ((0.5, 0.75),)}, "E505"),
    "cube": ({"curves": np.zeros((2, 3, 1))}, "E505"),
    "no lobe": ({"lobes": []}, "E505"),
    "whole numbers as reals": ({"dtype": lobe_dtype(integer="f8")}, "E505"),
}


@pytest.mark.parametrize(("changes", "code"), BAD_FILES.values(), ids=BAD_FILES)
def test_a_bad_file_is_refused(changes, code, tmp_path):
    with pytest.raises(InputFileError) as error:
        read(plain_file(tmp_path / "x.h5", **changes))
    assert codes(error) == [code]


ANIMATIONS = ["LobeAnims", "LobeAnims/a", "LobeAnims/a/Lobes", "LobeAnims/a/ReferenceTime"]


@pytest.mark.parametrize("name", [*ANIMATIONS, "SpectralCurves", "SpectralSamples"])
def test_a_missing_member_is_named(name, tmp_path):
    with pytest.raises(InputFileError) as error:
        read(plain_file(tmp_path / "x.h5", change=lambda file: operator.delitem(file, name)))
    assert codes(error) == ["E504"]
    assert name.removesuffix("/a") in str(error.value)


def test_all_problems_come_at_once(tmp_path):
    bad = lobe(kind=1, param0=2.0, coeff=-1, quaternion=(0, 0, 0, 0), curve=9, time=3)
    with pytest.raises(InputFileError) as error:
        read(plain_file(tmp_path / "x.h5", lobes=[bad, bad], version=3, samples=((3, 2, 1),), curves=-np.ones((1, 3))))
    assert codes(error) == ["E509", "E507", "E506", "E506", "E506", "E506", "E508", "E507"]
    assert "and 1 more like it" in str(error.value)

    def more(file):
        for k in range(30):
            file.copy("LobeAnims/a", f"LobeAnims/b{k}")

    with pytest.raises(InputFileError) as error:
        read(plain_file(tmp_path / "y.h5", lobes=[lobe(coeff=-1)], change=more))
    assert len(error.value.problems) == 31
    assert str(error.value).count("error[E506]") == 20
    assert "and 11 more problems" in str(error.value)

    def change(file):
        file.copy("LobeAnims/a", "LobeAnims/b")
        del file["LobeAnims/a/Lobes"]

    with pytest.raises(InputFileError) as error:
        read(plain_file(tmp_path / "x.h5", lobes=[lobe(coeff=-1)], change=change, version=2))
    assert codes(error) == ["E504", "E509", "E506"]

    def change(file):
        del file["LobeAnims/a/Lobes"]
        file["LobeAnims/a/Lobes"] = np.zeros(2, [("Type", "u4"), ("Param0", "f4")])

    with pytest.raises(InputFileError, match="no member Param1, Coeff, LocalTransform, CurveIndex, RelativeTime"):
        read(plain_file(tmp_path / "x.h5", change=change))


UP = (1.0, 0.0, 0.0, 0.0)


def one_lobe(kind="hg", **numbers):
    return animation([0.0], [1.0], kind=(kind,), **{name: np.array([number]) for name, number in numbers.items()})


def content(**changes):
    lobes = {
        "kind": ("ggx", "beckmann"), "param0": np.array([0.25, 0.3]), "param1": np.array([1.0, 0.1]),
        "quaternion": normalised(np.array([(1.0, 2.0, 3.0, 4.0), UP])), "curve_index": np.array([0, 1]),
        "reference": ReferenceType.ABSOLUTE, "time_point_s": 1_717_200_000,
    }  # fmt: skip
    base = BackgroundFile(
        info=BackgroundInfo(name="Küste", author="me", description="x" * 1000),
        animations={"z": one_lobe(), "a b": animation([0.0, 0.3], [1.0, 1.0], **lobes)},
        wavelength_nm=np.array([400.0, 500.5, 600.0]),
        curves=np.array([[1e-8, 2e-8, 0], [1, 2, 3]]),
    )
    return replace(base, **changes)


def test_what_is_written_is_what_plain_h5py_reads(tmp_path):
    write_background(tmp_path / "x.h5", content())
    with h5py.File(tmp_path / "x.h5") as file:
        assert sorted(file) == ["Info", "LobeAnims", "SpectralCurves", "SpectralSamples"]
        assert [file[f"Info/{name}"][()].tolist() for name in ("FileType", "FormatVersion")] == [[5], [1]]
        assert file["Info/Name"].asstr()[0] == "Küste"
        assert "Organization" not in file["Info"]
        lobes = file["LobeAnims/a b/Lobes"]
        assert (lobes.dtype, lobes.dtype.itemsize, lobes.shape) == (lobe_dtype(), 40, (2,))
        assert lobes["Type"].tolist() == [2, 3]
        assert lobes["CurveIndex"].tolist() == [0, 1]
        assert np.allclose(lobes["LocalTransform"][0], np.array([1, 2, 3, 4]) / np.sqrt(30), rtol=1e-7)
        reference = file["LobeAnims/a b/ReferenceTime"]
        assert (reference.dtype.itemsize, reference.shape) == (16, (1,))
        assert reference[()].tolist() == [(1, 1_717_200_000)]
        assert file["SpectralCurves"].dtype == np.dtype("<f4")
        assert file["SpectralSamples"].shape == (1, 3)
        assert np.array_equal(file["SpectralCurves"][()], np.array([[1e-9, 2e-9, 0], [0.1, 0.2, 0.3]], "f4"))
        assert np.array_equal(file["SpectralSamples"][0], np.array([0.4, 0.5005, 0.6], "f4"))


def test_writes_are_equal_and_keep_the_numbers(tmp_path):
    write_background(tmp_path / "x.h5", content())
    time.sleep(1.01)  # a time of creation would differ
    write_background(tmp_path / "y.h5", content(animations=dict(reversed(content().animations.items()))))
    assert (tmp_path / "x.h5").read_bytes() == (tmp_path / "y.h5").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.h5", "y.h5"]
    first = read(plain_file(tmp_path / "x.h5"))
    write_background(tmp_path / "y.h5", first)
    second = read(tmp_path / "y.h5")
    assert first.info == second.info
    assert np.array_equal(first.wavelength_nm, second.wavelength_nm)
    assert np.array_equal(first.curves, second.curves)
    for name in first.animations["a"].__slots__:
        assert np.array_equal(getattr(first.animations["a"], name), getattr(second.animations["a"], name)), name


BAD_CONTENT = {
    "g rounds to 1": {"animations": {"a": one_lobe(param0=1 - 1e-9)}},
    "alpha rounds to 0": {"animations": {"a": one_lobe("ggx", param0=1e-50, param1=1.0)}},
    "no animation": {"animations": {}},
    "lengths": {"animations": {"a": replace(one_lobe(), param0=np.zeros(2))}},
    "wavelengths round to one": {"wavelength_nm": np.array([400.0, 400.0 + 1e-9, 500.0])},
    "slash": {"animations": {"a/b": one_lobe()}},
    "nul": {"info": BackgroundInfo(name="a\0b")},
    "version": {"info": BackgroundInfo(format_version=2)},
    "shape": {"curves": np.zeros((2, 4))},
    "negative index": {"animations": {"a": one_lobe(curve_index=-1)}},
    "negative time point": {"animations": {"a": replace(one_lobe(), time_point_s=-1)}},
}


@pytest.mark.parametrize("changes", BAD_CONTENT.values(), ids=BAD_CONTENT)
def test_nothing_is_written_that_the_reader_would_refuse(changes, tmp_path):
    with pytest.raises(SceneError, match=r"error\[E50\d\]"):
        write_background(tmp_path / "x.h5", content(**changes))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "word", "value", "found"),
    [
        ("SpectralSamples", "units", "nm", "nm; um is read; write um"), ("SpectralSamples", "unit", "m", "m; um"),
        ("SpectralSamples", "units", "um", ""), ("SpectralSamples", "units", "µm", ""),
        ("SpectralSamples", "units", "", ""), ("SpectralCurves", "units", "W/cm^2/um", ""),
        ("SpectralCurves", "Units", "W m-2 nm-1", "W m-2 nm-1; W cm-2 um-1 is read; write W cm-2 um-1"),
        ("SpectralCurves", "units", "W cm-2 um-1 sr-1", "W cm-2 um-1 sr-1"),
        ("SpectralCurves", "units", "microflicks", "microflicks; W cm-2 um-1 is read; write W cm-2 um-1, or leave"),
        ("SpectralCurves", "scale_factor", 0.001, "0.001"), ("SpectralCurves", "scale_factor", "0.1", "0.1"),
        ("SpectralCurves", "scale_factor", 0.0, "0.0"), ("SpectralCurves", "scale_factor", "ten", "ten"),
        ("SpectralCurves", "scale_factor", 1.0, ""), ("SpectralCurves", "add_offset", [0.0, 1.0], "[0. 1.]"),
        ("SpectralCurves", "add_offset", 0.0, ""), ("SpectralCurves", "_FillValue", 0.0, ""),
        ("SpectralCurves", "_FillValue", np.zeros(0), ""), ("SpectralCurves", "missing_value", 1e300, ""),
    ],
)  # fmt: skip
def test_exact_keys_state_the_units_of_the_format_or_are_asked_about(name, word, value, found, tmp_path):
    path = plain_file(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        file[name].attrs[word] = value
    if not found:
        assert read(path).texts == ()
        return
    with pytest.raises(InputFileError) as caught:
        read(path)
    (problem,) = caught.value.problems
    said = f"{problem.code} {problem.field} {problem.message}; {problem.advice}"
    assert said.startswith(f"E506 /{name} its attribute {word} is {found}")


@pytest.mark.parametrize("name", ["SpectralSamples", "SpectralCurves"])
@pytest.mark.parametrize(
    ("word", "text"),
    [
        ("comment", "values are in mW"), ("note", "Werte mal 1000"), ("long_name", "irradiance in W m-2 um-1"),
        ("description", "divisé par 10 au préalable"), ("scaling_factor", 0.5), ("bemerkung", "lg der Bestrahlung"),
        ("说明", "数值乘以一千"), ("Gain", "wavelength [nm], x 1e-3"),
    ],
)  # fmt: skip
def test_texts_change_no_light_and_are_quoted(name, word, text, tmp_path):
    path = plain_file(tmp_path / "a.h5")
    silent = read(path)
    with h5py.File(path, "r+") as file:
        file[name].attrs[word] = text
        file["SpectralSamples"].attrs["many"] = ["texts", "are", "left out"]
    said = read(path)
    assert said == silent
    for spectrum in ("wavelength_nm", "curves"):
        assert getattr(said, spectrum).tobytes() == getattr(silent, spectrum).tobytes()
    shown = text if word in ("comment", "description", "long_name") else f"{word}: {text}"
    note = f'background a.h5: the file says "{shown}" (texts change nothing)'
    assert (silent.texts, said.texts) == ((), (note,))
    night = background_at([background_sky(said), background_sky(said)], 0.0)
    assert night.texts == night.notes([500.0]) == (note,)
    assert night == background_at([background_sky(silent), background_sky(silent)], 0.0)


@pytest.mark.parametrize(
    ("value", "missing_value", "found"),
    [
        (9999.0, None, "is 9999 a gap"),
        (999.9, None, "is 999.9 a gap"),
        (12.5, 12.5, "has the value 12.5 of its attribute missing_value"),
        (12.3, ["12.3"], "has the value 12.3 of its attribute missing_value"),
        (12.3, [7.0, 12.3], "has the value 12.3 of its attribute missing_value"),
        (9.96921e36, None, r"value \[0, 1\] is 9.96921e\+36 W cm-2 um-1; allowed: up to 1e\+30"),
    ],
)
def test_a_gap_is_no_light(value, missing_value, found, tmp_path):
    """Nines far above the other values, and what the file itself calls missing."""
    curves = np.array(CURVES, dtype=float)
    curves[0, 1] = value
    path = plain_file(tmp_path / "a.h5", curves=curves)
    if missing_value is not None:
        with h5py.File(path, "r+") as file:
            file["SpectralCurves"].attrs["missing_value"] = missing_value
    with pytest.raises(InputFileError, match=found):
        read(path)
