"""Write the sample weather files beside this script: invented hours in the layout of real files.

    python tests/data/weather/make_samples.py

Irradiances: pvlib's Haurwitz clear sky at the middle of each hour, times a cloud factor from a fixed list.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from pvlib import clearsky, irradiance, solarposition

HERE = Path(__file__).resolve().parent / "good"
INPUT = HERE.parents[3] / "inputs" / "weather" / "two_days.epw"
CLOUD = (1.0, 0.95, 0.6, 0.25, 0.8, 1.0, 0.1)


def hours(
    days: list[str], latitude: float, longitude: float, offset_h: float
) -> Iterator[tuple[pd.Timestamp, int, int, int]]:
    """Start of each hour in local standard time, and whole GHI, DNI, DHI of it. [W m-2]"""
    for number, day in enumerate(days):
        start = pd.date_range(day, periods=24, freq="1h")
        middle = (start + pd.Timedelta(minutes=30) - pd.Timedelta(hours=offset_h)).tz_localize("UTC")
        zenith = solarposition.get_solarposition(middle, latitude, longitude)["zenith"]
        cloud = np.array([CLOUD[(hour + 3 * number) % len(CLOUD)] for hour in range(24)])
        ghi = (clearsky.haurwitz(zenith)["ghi"] * cloud).round()
        split = irradiance.erbs(ghi, zenith, middle)
        for t, g, n, d in zip(start, ghi, split["dni"], split["dhi"], strict=True):
            yield t, int(g), round(n), round(d)


def epw() -> str:
    lines = [
        "LOCATION,Kleinmachnow,BB,DEU,invented,000000,52.40,13.22,1.0,40.0",
        "DESIGN CONDITIONS,0",
        "TYPICAL/EXTREME PERIODS,0",
        "GROUND TEMPERATURES,0",
        "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0",
        "COMMENTS 1,invented hours for a test",
        "COMMENTS 2,",
        "DATA PERIODS,1,1,Data,Sunday, 6/21, 6/22",
    ]
    for t, ghi, dni, dhi in hours(["2003-06-21", "2003-06-22"], 52.40, 13.22, 1.0):
        head = f"{t.year},{t.month},{t.day},{t.hour + 1},0,?9?9?9?9E0?9?9?9?9?9?9?9?9?9?9?9?9?9?9?9*9*9?9?9?9"
        rest = "999999,999999,999999,9999,180,2.0,5,5,20.0,77777,9,999999999,15,0.1,0,88,0.2,0.0,1.0"
        lines.append(f"{head},20.0,10.0,50,101300,0,0,300,{ghi},{dni},{dhi},{rest}")
    return "\n".join([*lines, ""])


def tmy3() -> str:
    names = "Date (MM/DD/YYYY),Time (HH:MM),ETR (W/m^2),ETRN (W/m^2),GHI (W/m^2),GHI source,GHI uncert (%),"
    names += "DNI (W/m^2),DNI source,DNI uncert (%),DHI (W/m^2),DHI source,DHI uncert (%)"
    lines = ['000000,"INVENTED FIELD",CO,-7.0,40.017,-105.250,1600', names]
    for t, ghi, dni, dhi in hours(["1996-02-28", "1998-03-21"], 40.017, -105.250, -7.0):
        lines.append(f"{t.month:02d}/{t.day:02d}/{t.year},{t.hour + 1:02d}:00,0,0,{ghi},1,8,{dni},1,9,{dhi},1,8")
    return "\n".join([*lines, ""])


def tmy2() -> str:
    lines = [" 00000 SAN INVENTADO          CA  -8 N 34 56 W 120 25    72"]
    for t, ghi, dni, dhi in hours(["1962-01-31", "1975-02-01"], 34 + 56 / 60, -(120 + 25 / 60), -8.0):
        start = f" {t.year % 100:02d}{t.month:02d}{t.day:02d}{t.hour + 1:02d}00000000{ghi:4d}E8{dni:4d}E8{dhi:4d}E8"
        lines.append(start + "0000?00000?00000?00000?010A710A70150C80100C8075C81015C8180A7020A70200B877777B8")
        lines[-1] += "0999999999010E8100F8000A7088A7"
    return "\n".join([*lines, ""])


if __name__ == "__main__":
    for name, text in (("invented.epw", epw()), ("invented.tmy3.csv", tmy3()), ("invented.tm2", tmy2())):
        (HERE / name).write_text(text, newline="\n")
    INPUT.write_text(epw(), newline="\n")
