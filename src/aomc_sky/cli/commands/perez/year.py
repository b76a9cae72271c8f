"""``aomc-sky perez --every hour``: a year of skies from a weather file."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli.commands.perez.sky import refuse_given
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.engine.year import YearResult

_OF_ONE_SKY = (
    "row",
    "sun_zenith",
    "sun_azimuth",
    "time",
    "latitude",
    "longitude",
    "dni",
    "dhi",
    "ghi",
    "epsilon",
    "delta",
    "coefficients",
    "extraterrestrial",
    "write_skydist",
    "counts",
    "plot",
)


def year(arguments: argparse.Namespace, kind: str) -> int:
    """Carry the year out."""
    refuse_given(arguments, _OF_ONE_SKY, f"--{kind} with --every hour")
    if arguments.strict:
        raise UsageError("--strict belongs to one sky; of a year, index.csv says what was limited in which hour")
    if arguments.out is None:
        raise UsageError("--every hour needs --out DIR")
    from aomc_sky.outputs.folder.target_file import check_folder

    check_folder(arguments.out, "--out")
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.year import run_year
    from aomc_sky.formats.weather import read_weather
    from aomc_sky.source.year.plan import plan_year

    path = getattr(arguments, kind)
    plan = plan_year(
        read_weather(path, kind),
        iterations=arguments.iterations,
        seed=arguments.seed,
        bins=(arguments.bins[0], arguments.bins[1]),
        limits=arguments.limits,
        air_mass=arguments.air_mass,
        with_beam=arguments.with_beam,
    )
    folder = Path(arguments.out)
    with progress_bar(enabled=not (arguments.quiet or arguments.json), unit="skies", per_unit=1.0) as progress:
        result = run_year(plan, folder, weather_file=path, force=arguments.force, progress=progress)
    if arguments.json:
        print(json.dumps({**result.manifest, "folder": str(folder), "was_finished": result.was_finished}))
    elif not arguments.quiet:
        print(_text(result, folder))
    return 0


def _text(result: YearResult, folder: Path) -> str:
    """What a year prints when it is done."""
    manifest: dict[str, Any] = result.manifest
    hours = manifest["hours"]
    lines = [f"{count:6d} hours  {_MEANING.get(state, state)}" for state, count in hours.items()]
    if manifest["hours_limited"]:
        lines.append(f"{manifest['hours_limited']:6d} of the skies had to be limited; index.csv says how")
    lines.append("")
    sky = hours.get("sky", 0)
    lines.append(f"{manifest['total']} photons in {sky} skies, seed {manifest['seed']}")
    if result.was_finished:
        lines.append("this year was finished before; nothing was done again (--force makes it anew)")
    else:
        rate = result.hours_done / max(result.seconds, 1e-9)
        lines.append(f"{result.hours_done} skies made in {result.seconds:.1f} s ({rate:.0f} per second)")
    lines.append(f"plan {manifest['plan_sha256'][:16]}, folder {folder}")
    return "\n".join(lines)


_MEANING = {
    "sky": "with a sky",
    "night": "with the sun below the horizon at their middle",
    "no-diffuse": "with DHI = 0: no sky to sample",
    "missing": "without DNI or DHI in the file",
    "no-light": "whose sky the model leaves without light; index.csv says why",
}
