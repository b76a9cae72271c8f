"""index.csv of a year: one line per row of the weather file, those without a sky among them."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from aomc_sky.errors import AomcSkyError
from aomc_sky.outputs.year_folder import INDEX
from aomc_sky.source.year_plan import HourState, YearPlan, state_text

INDEX_COLUMNS = (
    "row,line,start_utc,state,sun_zenith_deg,sun_azimuth_deg,extraterrestrial_normal,dni,dhi,"
    "epsilon,delta,counts_row,photons,note"
)
NO_LIGHT = "no-light"


def index_line(plan: YearPlan, row: int, *, sky: tuple[float, float, int, int] | None = None, note: str = "") -> str:
    """One line of index.csv."""
    arrays = plan.arrays
    start = np.datetime_as_string(arrays["start_s"][row].astype("M8[s]"), timezone="UTC")
    state = state_text(HourState(int(arrays["state"][row])))
    if note.startswith(NO_LIGHT):
        state, note = NO_LIGHT, note.partition(": ")[2]
    names = ("sun_zenith_deg", "sun_azimuth_deg", "extraterrestrial_normal", "dni", "dhi")
    fields = [row + 1, int(arrays["line"][row]), start, state, *(repr(float(arrays[name][row])) for name in names)]
    if sky is None:
        fields += ["", "", "", 0]
    else:
        epsilon, delta, counts_row, photons = sky
        fields += [repr(epsilon), repr(delta), counts_row, photons]
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="").writerow([*fields, " ".join(note.split())])
    return buffer.getvalue()


def read_index(folder: str | Path) -> list[dict[str, str]]:
    """Read index.csv of a year: one entry per row of the weather file, texts by column name.

    Raises
    ------
    AomcSkyError
        The folder holds no finished year.
    """
    path = Path(folder) / INDEX
    try:
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, ValueError) as error:
        raise AomcSkyError(
            f"{path} cannot be read; a year that was cut short goes on by its command ({error})"
        ) from error
    if not rows or ",".join(rows[0]) != INDEX_COLUMNS:
        raise AomcSkyError(f"{path} is not the index of a year of skies")
    return rows
