"""Names, units and record layouts of background-sky files, format version 1."""

from __future__ import annotations

import numpy as np

EXTRA = "hdf5"
NM_PER_UM = 1e3
SI_PER_FILE_UNIT = 10.0
"""W m-2 nm-1 in one W cm-2 um-1."""

TEXTS = {"Name": "name", "Author": "author", "Description": "description", "Organization": "organization"}
NUMBERS = {"FileType": "file_type", "FormatVersion": "format_version"}
OPTIONAL = ("Description", "Organization")
INFORMING = tuple(f"{place}{name}" for place in ("Info/", "@") for name in ("FileType", *TEXTS))
"""Members that say something to persons and nothing to us: no reason to refuse a file, whatever they hold."""
WANTED = (
    *(f"{place}{name}" for place in ("Info/", "@") for name in (*NUMBERS, *TEXTS)),
    "LobeAnims/*/Lobes",
    "LobeAnims/*/ReferenceTime",
    "SpectralCurves",
    "SpectralSamples",
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
