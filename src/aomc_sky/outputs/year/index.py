"""index.csv of a year: one line per row of the weather file, those without a sky among them."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import numpy as np

from aomc_sky.errors import AomcSkyError
from aomc_sky.formats.report import quoted
from aomc_sky.formats.text_file import refuse
from aomc_sky.outputs.year.folder import INDEX
from aomc_sky.regular_file import read_regular
from aomc_sky.source.year import HourState, YearPlan, state_text

INDEX_COLUMNS = (
    "row,line,start_utc,state,sun_zenith_deg,sun_azimuth_deg,extraterrestrial_normal,dni,dhi,"
    "epsilon,delta,counts_row,photons,note"
)
NO_LIGHT = "no-light"
MAX_INDEX_BYTES = 1 << 28
_STATES = {NO_LIGHT, *map(state_text, HourState)}
_WHOLE_NUMBER = re.compile("[0-9]{1,18}")


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

    AomcSkyError where the folder holds no finished year, or its index is not one that we write (E963).
    """
    path = Path(folder) / INDEX
    try:
        text = read_regular(path, MAX_INDEX_BYTES, follow_links=False).decode("utf-8")
        rows = list(csv.DictReader(io.StringIO(text, newline="")))
    except (OSError, ValueError, csv.Error) as error:
        raise AomcSkyError(
            f"{path} cannot be read; a year that was cut short goes on by its command ({error})"
        ) from error
    if not rows or ",".join(map(str, rows[0])) != INDEX_COLUMNS:
        raise AomcSkyError(f"{path} is not the index of a year of skies")
    for line, row in enumerate(rows, 2):
        _check_row(path, line, row)
    return rows


def _check_row(path: Path, line: int, row: dict[str, str]) -> None:
    """Raise for a row that no year of ours has: other columns, another state, no number where one is wanted."""
    numbers = ("row", "line", "photons", *(("counts_row",) if row.get("counts_row") else ()))
    if len(row) != INDEX_COLUMNS.count(",") + 1 or None in row.values():
        fault = "another number of columns than the first line"
    elif row["state"] not in _STATES:
        fault = f"state {quoted(row['state'])}"
    elif wrong := [name for name in numbers if not _WHOLE_NUMBER.fullmatch(row[name])]:
        fault = f"{wrong[0]} {quoted(row[wrong[0]])}"
    else:
        return
    advice = "remove manifest.json, index.csv and counts.npy; the command of the year makes them again"
    raise refuse(path, f"no index of ours: {fault}", code="E963", line=line, column=1, advice=advice)
