"""Background-sky files (DIRSIG BackgroundSkyData, HDF5): reader and writer."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.errors import require_kind
from aomc_sky.extras import optional_module
from aomc_sky.formats.quote import quote, texts_of
from aomc_sky.formats.radiance_unit import radiance_factor
from aomc_sky.formats.radiance_words import LENGTH_NM, plain_unit
from aomc_sky.formats.report import Report, printable
from aomc_sky.formats.text_file import write_bytes_atomically
from aomc_sky.skies.lobes.file.check import NM_PER_UM, SI_PER_FILE_UNIT, add, check_sky, close_by_hand
from aomc_sky.skies.lobes.file.data import (
    Animation,
    BackgroundFile,
    BackgroundInfo,
    LobeType,
    ReferenceType,
    frozen,
    normalised,
)
from aomc_sky.skies.lobes.file.hdf5_members import (
    EXTRA,
    FILLS,
    INFORMING,
    NEUTRAL,
    NUMBERS,
    OPTIONAL,
    STATING,
    TEXTS,
    UNITS,
    Hdf5Members,
    read_members,
)

LOBE = np.dtype(
    [
        ("Type", "<u4"),
        ("Param0", "<f4"),
        ("Param1", "<f4"),
        ("Coeff", "<f4"),
        ("LocalTransform", "<f4", (4,)),
        ("CurveIndex", "<u4"),
        ("RelativeTime", "<f4"),
    ]
)
REFERENCE = np.dtype({"names": ["Type", "TimePoint"], "formats": ["<u4", "<u8"], "offsets": [0, 8], "itemsize": 16})

_LIKE = "write it as docs/formats/background.md has it"
MAX_EXPECTED_UM = 100.0  #: A shortest wavelength beyond this one is more likely given in nanometres. [um]
_MOST_DIGITS = 10  # of a file type that is written as a text
_INTEGERS = ("Type", "CurveIndex", "TimePoint")


def _in_micrometres(unit: str) -> float:
    return LENGTH_NM.get(plain_unit(unit), 0.0) / NM_PER_UM


def _in_file_unit(unit: str) -> float:
    if radiance_factor(unit):
        return np.nan  # a radiance, which is no irradiance
    return (radiance_factor(f"{unit} sr-1") or 0.0) / SI_PER_FILE_UNIT


_UNITS = {"SpectralSamples": ("um", _in_micrometres), "SpectralCurves": ("W cm-2 um-1", _in_file_unit)}
"""Units of the format, and a unit in them; 0 for what is none."""


def read_background_file(path: str | Path) -> BackgroundFile:
    """Read a background-sky file into our units.

    Members are found by name, whatever their width, byte order and padding. The texts and numbers of ``/Info`` may be
    attributes of the root instead. Name, author, organization, description and file type are for persons: they may be a
    text, a list of texts or numbers. Anything else is a warning. Quaternions are normalised in float64. ``Param1`` of a
    Henyey-Greenstein lobe has no meaning and becomes 0.

    h5py opens the file in this process. No other file is opened, and no array is read that is larger than a file of
    this size can hold. A file that is made to harm the HDF5 library itself is a matter of that library. InputFileError:
    every problem of the file, codes E500 to E509. MissingExtraError: h5py is not installed (``pip install
    ".[hdf5]"``).

    Parameters
    ----------
    path : str or Path
        The file. [at most 1 GiB]

    Returns
    -------
    BackgroundFile
        Wavelengths in nm and curves in W m-2 nm-1, from micrometres and W cm-2 um-1 in the file.

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> sky.lobes.write_background(
    ...     "town.h5", sky.lobes.background_of_lobes({"town": town}, [550.0], name="A town")
    ... )
    >>> sky.lobes.read_background_file("town.h5").info.name
    'A town'
    """
    report = Report(path=str(path))
    members = read_members(path, report)
    file = background_of_members(members, report)
    if file is not None:
        check_background(file, report)
    report.close()
    if file is None:  # background_of_members reports why
        raise AssertionError(f"nothing is reported of {path}")
    return file


def background_of_members(members: Hdf5Members, report: Report) -> BackgroundFile | None:
    """Build a file from its members, without the animations that are reported (E504, E505); None without spectra."""
    info = _info(members, report)
    paths = sorted(n for n in members.names if n.startswith("LobeAnims/") and n.count("/") == 1)
    if not paths and not any(p.field.startswith("/LobeAnims") for p in report.problems):
        report.add("E504", "no animation, or no such group", name="/LobeAnims", advice="give at least one lobe")
    made = {path.removeprefix("LobeAnims/"): _animation(members, path, report) for path in paths}
    texts, spectra = _texts(members, report), _spectra(members, report)
    if spectra is None:
        return None
    wavelength, curves = spectra
    return BackgroundFile(
        info=info,
        animations={name: animation for name, animation in made.items() if animation is not None},
        wavelength_nm=frozen(wavelength * NM_PER_UM),
        curves=frozen(curves * SI_PER_FILE_UNIT),
        texts=texts,
    )


def _spectra(members: Hdf5Members, report: Report) -> tuple[np.ndarray, np.ndarray] | None:
    """Wavelengths (n_wavelength,) and curves (n_curve, n_wavelength) in the units of the file."""
    wavelength = _plain(members, "SpectralSamples", report)
    curves = _plain(members, "SpectralCurves", report)
    if wavelength is None or curves is None:
        return None
    wavelength = wavelength.reshape(-1) if sum(n != 1 for n in wavelength.shape) <= 1 else wavelength
    if curves.ndim == 1 and curves.shape == wavelength.shape:
        curves = curves[np.newaxis]
    if wavelength.ndim != 1 or curves.ndim != 2 or curves.shape[1] != wavelength.size or curves.size == 0:
        message = f"shape {curves.shape} with SpectralSamples of shape {wavelength.shape}"
        allowed = "allowed: (curves, wavelengths) and (1, wavelengths), both at least 1"
        report.add("E505", f"{message}; {allowed}", name="/SpectralCurves", advice="one row per curve")
        return None
    if wavelength.min() > MAX_EXPECTED_UM:
        message = f"the wavelengths begin at {wavelength.min():g} micrometres, much longer than light"
        advice = "divide them by 1000 if they are nanometres"
        report.add("E506", message, name="/SpectralSamples", advice=advice, is_warning=True)
    return wavelength, curves


def _texts(members: Hdf5Members, report: Report) -> tuple[str, ...]:
    """Check what attributes of the spectra state, by exact keys; a note quotes all others."""
    others: list[str] = []
    for name, (unit, share_of) in _UNITS.items():
        keys = sorted(key for key in (*members.texts, *members.arrays) if key.startswith(f"{name}@"))
        said = {
            key.partition("@")[2]: np.squeeze(np.array(members.texts.get(key, members.arrays.get(key)))) for key in keys
        }
        others += texts_of({word: value for word, value in said.items() if word.lower() not in STATING})
        for word, value in said.items():
            key, text, number = word.lower(), str(value), _number_of(value)
            share = share_of(text) if key in UNITS and text.strip() else 1.0
            is_factor = key in NEUTRAL and (number is None or np.any(number != NEUTRAL[key]))
            if is_factor or not np.isclose(share, 1.0):
                message = f"its attribute {word} is {printable(text)}; {unit} is read"
                advice = f"write {unit}" + (", or leave the attribute out" if share == 0.0 else "")
                report.add("E506", message, name=f"/{name}", advice=advice)
            if key in FILLS and number is not None:
                _check_fill(members, name, word, number, report)
    return tuple(f"background {printable(Path(report.path).name)}: {note}" for note in quote(others))


def _number_of(value: np.ndarray) -> np.ndarray | None:
    """Numbers, or a text that is one."""
    try:
        return value.astype(np.float64)
    except ValueError:
        return None


def _check_fill(members: Hdf5Members, name: str, word: str, number: np.ndarray, report: Report) -> None:
    """Report values that the file itself calls missing."""
    values = members.arrays.get(name, np.zeros(0))
    with np.errstate(over="ignore", invalid="ignore"):
        found = values[np.isin(values, number.astype(values.dtype)) & (values != 0)]  # 0 is no light in any case
    if found.size:
        message = f"has the value {found[0]:g} of its attribute {word}, which is missing"
        report.add("E506", message, name=f"/{name}", advice="write a value for each wavelength, or leave it out")


def _info(members: Hdf5Members, report: Report) -> BackgroundInfo:
    """Title and version of a file; only its format version is a reason to refuse it."""
    values: dict[str, Any] = {}
    for name, field in (*NUMBERS.items(), *TEXTS.items()):
        paths = [f"Info/{name}", f"@{name}"]
        value = next((v for p in paths if (v := _info_value(members, p, is_number=name in NUMBERS)) is not None), None)
        if value is not None:
            values[field] = value
        elif _is_reported(report, f"Info/{name}") or any(p.field == f"attribute {name}" for p in report.problems):
            continue
        elif any(_is_there(members, p) for p in paths):
            kind = "one whole number" if name in NUMBERS else "one text"
            is_warning = f"Info/{name}" in INFORMING
            message = f"expected {kind}" + (f"; {_default(field)!r} is used" if is_warning else "")
            report.add("E505", message, name=f"/Info/{name}", advice=_LIKE, is_warning=is_warning)
        elif name not in OPTIONAL:
            message = f"missing, here and in the attributes of the root; {_default(field)!r} is used"
            report.add("E504", message, name=f"/Info/{name}", advice="write it", is_warning=True)
    return BackgroundInfo(**values)


def _is_there(members: Hdf5Members, path: str) -> bool:
    """Whether there is such a member, be it a group or a record, whose parts have names of their own."""
    held = (path in some for some in (members.names, members.arrays, members.texts))
    return any(held) or any(name.startswith(f"{path}/") for name in members.arrays)


def _info_value(members: Hdf5Members, path: str, *, is_number: bool) -> int | str | None:
    """A member of /Info as a number or a text, or None."""
    array, text = members.arrays.get(path), members.texts.get(path)
    if not is_number:
        return text if array is None else ", ".join(f"{value:.15g}" for value in array.reshape(-1).tolist())
    if array is not None and array.size == 1:
        value = array.reshape(-1)[0]
        return int(value) if np.isfinite(value) and value == int(value) else None
    if text is not None and path in INFORMING and text.isdecimal() and len(text) <= _MOST_DIGITS:
        return int(text)
    return None


def _default(field: str) -> object:
    return getattr(BackgroundInfo(), field)


def _plain(members: Hdf5Members, path: str, report: Report) -> np.ndarray | None:
    """An array of numbers as float64, or None and a report."""
    array = members.arrays.get(path)
    if array is not None:
        return array.astype(np.float64)
    if _is_reported(report, path):
        return None
    if path not in members.names:
        report.add("E504", "there is no such dataset", name=f"/{path}", advice=_LIKE)
    else:
        report.add("E505", "it is not a dataset of plain numbers", name=f"/{path}", advice=_LIKE)
    return None


def _is_reported(report: Report, path: str) -> bool:
    return any(p.field == printable(f"/{path}") for p in report.problems)


def _animation(members: Hdf5Members, path: str, report: Report) -> Animation | None:
    lobes = _record(members, f"{path}/Lobes", tuple(LOBE.names or ()), report)
    reference = _record(members, f"{path}/ReferenceTime", ("Type", "TimePoint"), report)
    if lobes is None or reference is None:
        return None
    kind = int(reference["Type"][0]) if reference["Type"].size == 1 else 0
    if kind not in list(ReferenceType):
        message = f"Type is {kind}" if reference["Type"].size == 1 else f"{reference['Type'].size} records, expected 1"
        allowed = "allowed: 1 (absolute), 2 (diurnal) or 3 (hebdomadal)"
        shown = printable(f"/{path}/ReferenceTime")
        report.add("E506", f"{message}; {allowed}", name=shown, advice="write one record of these types")
        return None
    is_hg = lobes["Type"] == LobeType.HENYEY_GREENSTEIN
    return Animation(
        lobe_type=frozen(np.clip(lobes["Type"], 0, 255).astype(np.uint8)),
        param0=frozen(lobes["Param0"].astype(np.float64)),
        param1=frozen(np.where(is_hg, 0.0, lobes["Param1"]).astype(np.float64)),
        coefficient=frozen(lobes["Coeff"].astype(np.float64)),
        quaternion=normalised(lobes["LocalTransform"].astype(np.float64)),
        curve_index=frozen(np.minimum(lobes["CurveIndex"], np.iinfo(np.int64).max).astype(np.int64)),
        relative_time_days=frozen(lobes["RelativeTime"].astype(np.float64)),
        reference=ReferenceType(kind),
        time_point_s=int(reference["TimePoint"][0]),
    )


def _record(members: Hdf5Members, path: str, fields: tuple[str, ...], report: Report) -> dict[str, np.ndarray] | None:
    """The members of a table of records, each of shape (n,) or (n, 4), or None and a report."""
    shown = printable(f"/{path}")
    if _is_reported(report, path):
        return None
    if path not in members.names:
        report.add("E504", "there is no such dataset", name=shown, advice=_LIKE)
        return None
    missing = [f for f in fields if f"{path}/{f}" not in members.arrays]
    if missing:
        report.add("E504", f"the records have no member {', '.join(missing)}", name=shown, advice=_LIKE)
        return None
    record = {}
    for field in fields:
        values = members.arrays[f"{path}/{field}"]
        tail = (4,) if field == "LocalTransform" else ()
        shape = values.shape[: values.ndim - len(tail)]
        is_kind = values.dtype.kind in ("iu" if field in _INTEGERS else "iuf")
        if values.shape[len(shape) :] != tail or sum(n != 1 for n in shape) > 1 or not is_kind:
            kind = f"{'whole numbers' if field in _INTEGERS else 'numbers'}, shape {('n', *tail)}"
            message = f"{field} has shape {values.shape} and type {values.dtype}; expected {kind}"
            report.add("E505", message, name=shown, advice=_LIKE)
            return None
        record[field] = values.reshape(-1, *tail)
    return record


def check_background(file: BackgroundFile, report: Report) -> None:
    """Report another version than 1, and the faults of `check_sky`."""
    if file.info.format_version != 1:
        message = f"format version {file.info.format_version}; version 1 is read"
        add(report, "E509", "/Info/FormatVersion", message, "write 1")
    check_sky(file.animations, file.wavelength_nm, file.curves, report)


def check_storable(background: BackgroundFile, report: Report) -> None:
    """Report names and texts that HDF5 does not hold, and numbers too large."""
    for field in TEXTS.values():
        if not _is_text(getattr(background.info, field)):
            add(report, "E505", field, "a text with NUL characters or lone surrogates", "leave them out")
    for field in NUMBERS.values():
        if not 0 <= getattr(background.info, field) < 2**32:
            message = f"{getattr(background.info, field)}; allowed: 0 to 2^32 - 1"
            add(report, "E505", field, message, "write such a number")
    if not background.animations:
        add(report, "E504", "animations", "no animation", "give at least one lobe")
    for name, keys in background.animations.items():
        if not _is_text(name) or "/" in name or name in ("", ".", ".."):
            advice = "leave out slashes and NUL, and give it letters"
            add(report, "E502", repr(name), "not a name of an animation", advice)
        if not 0 <= keys.time_point_s < 2**64:
            message = f"time point {keys.time_point_s} s; allowed: 0 to 2^64 - 1"
            add(report, "E507", name, message, "count from 1970-01-01 UTC")


def _is_text(text: str) -> bool:
    return "\0" not in text and not any("\ud800" <= c <= "\udfff" for c in text)


def write_background(path: str | Path, background: BackgroundFile) -> None:
    """Write a background-sky file, atomically; equal content gives equal bytes with one version of the library.

    SceneError: values that the reader would refuse, rounded to float32; nothing is written. OutputError: the operating
    system refuses; nothing was changed. MissingExtraError: h5py is not installed (``pip install ".[hdf5]"``).

    Parameters
    ----------
    path : str or Path
        The file; its folder must exist.
    background : BackgroundFile
        Content in our units; it is stored in the widths of the format, float32 and uint32.

    Examples
    --------
    >>> town = sky.lobes.SkyLobe(kind="hg", width=0.8, zenith_deg=85.0, spectrum=[1e-8])
    >>> sky.lobes.write_background(
    ...     "town.h5", sky.lobes.background_of_lobes({"town": town}, [550.0])
    ... )
    """
    require_kind(background, BackgroundFile, "sky.lobes.background_of_lobes({'town': lobe}, [550.0])")
    report = Report(path=str(path))
    check_storable(background, report)
    if not report.has_errors:
        check_background(as_stored(background), report)
    close_by_hand(report)
    write_bytes_atomically(path, encode_background(background))


def as_stored(background: BackgroundFile) -> BackgroundFile:
    """The content rounded to the widths of the file."""
    return replace(
        background,
        animations={
            name: replace(
                keys,
                param0=_rounded(keys.param0),
                param1=_rounded(keys.param1),
                coefficient=_rounded(keys.coefficient),
                relative_time_days=_rounded(keys.relative_time_days),
            )
            for name, keys in background.animations.items()
        },
        wavelength_nm=_rounded(background.wavelength_nm / NM_PER_UM) * NM_PER_UM,
        curves=_rounded(background.curves / SI_PER_FILE_UNIT) * SI_PER_FILE_UNIT,
    )


def encode_background(background: BackgroundFile) -> bytes:
    """The file, made in memory, for the HDF5 library dies of a full disk where it should report one."""
    h5py = optional_module("h5py", extra=EXTRA)
    buffer = io.BytesIO()
    # the oldest layout has no times of creation; every version of the library reads it
    with h5py.File(buffer, "w", libver="earliest", track_order=False) as file:
        info = file.create_group("Info")
        for name, field in NUMBERS.items():
            info.create_dataset(name, data=np.array([getattr(background.info, field)], "<u4"), track_times=False)
        for name, field in TEXTS.items():
            text = getattr(background.info, field)
            if text or name not in OPTIONAL:
                info.create_dataset(name, data=[text], dtype=h5py.string_dtype(), track_times=False)
        animations = file.create_group("LobeAnims")
        for name in sorted(background.animations):
            group, keys = animations.create_group(name), background.animations[name]
            lobes, reference = np.zeros(len(keys), LOBE), np.zeros(1, REFERENCE)
            lobes["Type"] = keys.lobe_type
            lobes["Param0"], lobes["Param1"], lobes["Coeff"] = keys.param0, keys.param1, keys.coefficient
            lobes["LocalTransform"], lobes["CurveIndex"] = keys.quaternion, keys.curve_index
            lobes["RelativeTime"] = keys.relative_time_days
            reference["Type"], reference["TimePoint"] = ReferenceType(keys.reference), keys.time_point_s
            group.create_dataset("Lobes", data=lobes, track_times=False)
            group.create_dataset("ReferenceTime", data=reference, track_times=False)
        samples = _single(background.wavelength_nm / NM_PER_UM)[np.newaxis]
        file.create_dataset("SpectralCurves", data=_single(background.curves / SI_PER_FILE_UNIT), track_times=False)
        file.create_dataset("SpectralSamples", data=samples, track_times=False)
    return buffer.getvalue()


def _single(values: np.ndarray) -> np.ndarray:
    """Rounded to float32; what is too large becomes infinite, which the checks refuse."""
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(values, np.float64).astype("<f4")


def _rounded(values: np.ndarray) -> np.ndarray:
    return _single(values).astype(np.float64)
