"""Background-sky files made by h5py alone, in every shape that a writer may choose; never by our own writer."""

import numpy as np

LOBES = (
    (1, 0.5, 7.0, 0.25, (2.0, 0.0, 0.0, 0.0), 1, 0.0),
    (2, 0.25, 1.5, 1.0, (0.5, -0.5, 0.5, 0.5), 0, 0.25),
    (3, 0.375, 2.0, 0.0, (0.0, 0.0, 0.0, -3.0), 1, 1.0),
)
"""Type, Param0, Param1, Coeff, LocalTransform, CurveIndex, RelativeTime of three keys."""
CURVES = ((1e-9, 2e-9, 0.0), (4e-9, 0.5, 1.0))
SAMPLES = (0.5, 0.625, 0.75)
NAMES = ("Type", "Param0", "Param1", "Coeff", "LocalTransform", "CurveIndex", "RelativeTime")


def lobe_dtype(order="<", real="f4", integer="u4", *, reverse=False, padding=0):
    """Records of lobes with these widths, members in reverse order, each with spare bytes before it."""
    kinds = [integer, real, real, real, (real, (4,)), integer, real]
    kinds = [(f"{order}{k[0]}", k[1]) if isinstance(k, tuple) else f"{order}{k}" for k in kinds]
    pairs = list(zip(NAMES, kinds, strict=True))
    offsets, place = [], 0
    for _, kind in pairs[::-1] if reverse else pairs:
        place += padding
        offsets.append(place)
        place += np.dtype(kind).itemsize
    names, formats = zip(*(pairs[::-1] if reverse else pairs), strict=True)
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": place + padding})


def plain_file(
    path,
    *,
    lobes=LOBES,
    dtype=None,
    reference=(2, 0),
    curves=CURVES,
    samples=(SAMPLES,),
    spectrum="<f4",
    info="datasets",
    version=1,
    libver="earliest",
    change=None,
    **storage,
):
    """Write a file with one animation ``a``; `change` gets the open file, `storage` goes to create_dataset."""
    import h5py

    with h5py.File(path, "w", libver=libver) as file:
        group = file.create_group("LobeAnims/a")
        dtype = lobe_dtype() if dtype is None else dtype
        table = np.zeros(len(lobes), dtype)
        for k, lobe in enumerate(lobes):
            for name, value in zip(NAMES, lobe, strict=True):
                table[name][k] = value
        group.create_dataset("Lobes", data=table, **storage)
        kind = np.dtype([("Type", "<u4"), ("TimePoint", "<u8")], align=True)
        group.create_dataset("ReferenceTime", data=np.array([reference], kind))
        file.create_dataset("SpectralCurves", data=np.array(curves, spectrum), **storage)
        file.create_dataset("SpectralSamples", data=np.array(samples, spectrum))
        _write_info(file, info, version)
        if change is not None:
            change(file)
    return path


def _write_info(file, form, version):
    values = {"FileType": np.array([5], "<u4"), "FormatVersion": np.array([version], "<u4")}
    texts = {"Name": "sky", "Author": "Grüße", "Organization": "none"}
    if form == "attributes":
        for name, number in values.items():
            file.attrs[name] = number
        for name, text in texts.items():
            file.attrs[name] = text
    elif form == "fixed":
        for name, number in values.items():
            file[f"Info/{name}"] = number[0]
        for name, text in texts.items():
            file[f"Info/{name}"] = np.bytes_(text.encode().ljust(16, b"\0"))
    elif form == "datasets":
        for name, number in values.items():
            file[f"Info/{name}"] = number
        for name, text in texts.items():
            file[f"Info/{name}"] = [text]
