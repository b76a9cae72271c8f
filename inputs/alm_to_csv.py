"""Almucantars and principal planes of AERONET (version 3) as a table: python alm_to_csv.py FILE DATE,HOUR > sky.csv."""

import csv
import sys
from pathlib import Path

SCAN, SUN, NM = "Sky_Scan_Type", "Solar_Zenith_Angle(Degrees)", "Nominal_Wavelength(nm)"
DATE, TIME = "Date(dd:mm:yyyy)", "Time(hh:mm:ss)"


def number(text):
    """Make a word that is no number NaN."""
    try:
        return float(text)
    except ValueError:
        return float("nan")


path, hour = sys.argv[1:]
lines = [[""]] + [[cell.strip() for cell in line] for line in csv.reader(Path(path).read_text("latin-1").splitlines())]
start = next((k for k, line in enumerate(lines) if {SCAN, SUN, NM, DATE, TIME} <= set(line)), 0)
start or sys.exit(f"{path} has no row of names with {SCAN}, {SUN}, {NM}, {DATE} and {TIME}")
names, above, block, angles = lines[start], lines[start - 1], "", {}
for k, name in enumerate(names):
    if abs(number(name)) <= 180:
        block = above[k] if k < len(above) and above[k] else block
        if block and not block.startswith(("Radiance_for_", "Scattering_Angle_for_")):
            sys.exit(f"{path}: column {k + 1} belongs to an unknown block, {block}")
        if not block.startswith("Scattering_Angle_for_"):
            angles[k] = float(name)
given, half = [*angles.values()], len(angles) // 2
if given and given[:half] == given[half:]:
    sys.exit(f"{path} has a second block of the same angles, and no row above it says what it is")
table, suns, gaps = [], [], 0
for line in lines[start + 1 :]:
    row = dict(zip(names, line, strict=False))
    if f"{row.get(DATE)},{row.get(TIME)}".startswith(hour):
        if row[SCAN] not in ("Almucantar", "Principal Plane"):
            sys.exit(f"{path}: {SCAN} is {row[SCAN]}; only Almucantar and Principal Plane are converted")
        suns.append(number(row[SUN]))
        for k, angle in angles.items():
            zenith, azimuth = (suns[-1], angle) if row[SCAN] == "Almucantar" else (suns[-1] - angle, 0)
            if k < len(line) and number(line[k]) > 0 and angle and 0 <= suns[-1] <= 90:
                table.append(f"{abs(zenith):.4f},{azimuth if zenith >= 0 else 180:g},{row[NM]},{line[k]}")
            else:
                gaps += 1
table or sys.exit(f"{path} has no radiance at {hour}")
print("# azimuth: clockwise from the sun\n# radiance unit: uW cm-2 nm-1 sr-1")
if max(suns) - min(suns) <= 0.5:
    print(f"# sun zenith: {sum(suns) / len(suns):.2f}")
print("zenith_deg,azimuth_deg,wavelength_nm,radiance", *table, sep="\n")
print(
    f"{len(table)} radiances of {len(suns)} rows; {gaps} cells left out: gaps such as -999, and the sun itself",
    file=sys.stderr,
)
