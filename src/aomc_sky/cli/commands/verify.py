"""``aomc-sky verify``: check a run, or photons that another code made."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.terminal import table
from aomc_sky.errors import UsageError
from aomc_sky.source.read.kind import Kind, kind_of

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.verify.report import Check, Pulls, VerifyReport

_EPILOG = """\
examples:
  aomc-sky verify out                                    counts and photons made again, every bit compared
  aomc-sky verify out --resample 0.01                    a hundredth of the photons, drawn at random
  aomc-sky verify out --scene amc.inp                    besides, the plan made again from the scene's files
  aomc-sky verify out --statistics                       besides, tests of the directions against the sky
  aomc-sky verify --scene amc.inp photons.mcpl           photons of another code, drawn independently, or of ours
  aomc-sky verify --scene amc.inp --compat aomc --frame down --method stratified aomc.npy
"""

GROUPS = {
    "": "json verify.quiet verify.verbose",
    "what is checked": "verify.waveband resample statistics level verify.seed threads",
    "photons of another code": "verify.scene verify.wavelengths verify.method frame verify.weights",
    **cli_options.READING,
    **cli_options.WHEN,
}
FIRST = "waveband resample statistics scene method frame compat threads json quiet verbose"

FAILED, FOREIGN = 1, 5
"""Exit codes: a check failed; files belong to another scene, seed or run."""


def add_options(parser: Parser) -> None:
    """Add the options of the sub-command."""
    parser.description = (
        "Check a run folder: make its counts and photons again from the plan and compare every bit with the files. "
        "With --scene and a file: test photons that another code made against the sky of a scene."
    )
    parser.epilog = _EPILOG
    parser.add_argument("path", metavar="PATH", help="run folder; with --scene a .npy, .mcpl or .mcpl.gz file")
    cli_options.add_groups(parser, GROUPS)
    parser.show_first(FIRST)
    parser.set_defaults(handler=verify)


def verify(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    _refuse_mixture(arguments)
    is_run = arguments.scene is None or Path(arguments.path).is_dir()
    report = _run_report(arguments) if is_run else _photon_report(arguments)
    if arguments.json:
        print(json.dumps({"path": arguments.path, **report.as_json()}))
    elif not (arguments.quiet and report.passed):
        print(report_text(report, verbose=arguments.verbose, only_failed=arguments.quiet))
    if report.passed:
        return 0
    return FOREIGN if report.is_foreign else FAILED


def _refuse_mixture(arguments: argparse.Namespace) -> None:
    """Refuse options of a run together with options of photons of another code."""
    is_folder = Path(arguments.path).is_dir()
    if not is_folder and kind_of(Path(arguments.path)) is Kind.SOURCE:
        raise UsageError(
            f"{arguments.path} is {Kind.SOURCE.value}: give the folder of its run, which is made again with it"
        )
    if arguments.scene is not None and not is_folder:
        for name, is_given in (("resample", arguments.resample is not None), ("statistics", arguments.statistics)):
            if is_given:
                raise UsageError(f"--{name} is for runs: photons of another code have no plan, and are always tested")
        return
    for name in ("method", "frame", "weights"):
        if getattr(arguments, name) is not None:
            advice = "give their file instead of the folder, and" if is_folder else "give their"
            raise UsageError(f"--{name} is for photons of another code: {advice} --scene AMC_INP")
    if not is_folder and Path(arguments.path).exists():
        kind = kind_of(Path(arguments.path))
        what = "a file" if kind is None else kind.value
        raise UsageError(f"{arguments.path} is {what}: give a run folder, or --scene AMC_INP for photons of any code")
    reading = cli_options.given_options(arguments, *cli_options.names_of(cli_options.READING | cli_options.WHEN))
    reading += ["--wavelengths"] if arguments.wavelengths else []
    for name in reading if arguments.scene is None else ():
        raise UsageError(f"{name} says how a scene is read; a run is checked against its own plan: leave it out")


def _run_report(arguments: argparse.Namespace) -> VerifyReport:
    import secrets

    from aomc_sky.engine.stored_run import open_run
    from aomc_sky.progress import progress_bar, status_line
    from aomc_sky.verify.report import Check, judged
    from aomc_sky.verify.reproduce import scene_checks, statistics_of_run, verify_run

    with status_line("reading the run", enabled=cli_options.is_verbose(arguments)):
        run = open_run(arguments.path)
    if run.manifest is None:
        detail = (
            "there is no manifest.json: a run that is not finished, which the same run command finishes, or an export; "
            "verify the run that it came from"
        )
        return judged([Check(name="finished", passed=False, detail=detail)], family_level=arguments.level)
    bands, threads = run.chosen(arguments.waveband), arguments.threads or 0
    with progress_bar(enabled=cli_options.is_verbose(arguments)) as progress:
        report = verify_run(
            run.path,
            run.source,
            run.manifest,
            bands,
            resample=1.0 if arguments.resample is None else arguments.resample,
            seed=secrets.randbits(64) if arguments.seed is None else arguments.seed,
            threads=threads,
            progress=progress,
        )
    checks, pulls, notes = list(report.checks), list(report.pulls), list(report.notes)
    if arguments.scene is not None:
        said = run.manifest["options"]["scene"].get("wavebands")
        wavebands = said if isinstance(said, list) else None
        scene = cli_options.scene_of(arguments, arguments.scene, wavebands=wavebands)
        checks += scene_checks(run.source.plan, run.manifest, scene)
    if arguments.statistics:
        how = {"family_level": arguments.level, "seed": arguments.seed or 0, "threads": threads}
        tests = statistics_of_run(run.path, run.source, bands, **how)
        checks, pulls, notes = [*checks, *tests.checks], [*pulls, *tests.pulls], [*notes, *tests.notes]
    return judged(checks, family_level=arguments.level, notes=notes, pulls=pulls)


def _photon_report(arguments: argparse.Namespace) -> VerifyReport:
    from aomc_sky.directions import Frame
    from aomc_sky.progress import status_line
    from aomc_sky.verify.directions import Dependence
    from aomc_sky.verify.foreign import Origin, open_photons, origin_of, verify_photons

    scene = cli_options.scene_of(arguments, arguments.scene)
    source = scene.source(max_memory_bytes=arguments.max_memory)
    photons = open_photons(
        arguments.path, scene.wavebands.wavelength_nm, wavebands=arguments.waveband, weights=arguments.weights
    )
    if arguments.method is None:
        origin = origin_of(photons, scene, own_numbers=arguments.iterations is not None)
    else:
        origin = Origin(dependence=Dependence(arguments.method))
    with status_line("comparing the photons", enabled=cli_options.is_verbose(arguments)):
        return verify_photons(
            source,
            photons,
            origin,
            frame=Frame(arguments.frame or "up"),
            family_level=arguments.level,
            seed=arguments.seed or 0,
            threads=arguments.threads or 0,
        )


_HEAD = ("check", "waveband", "outcome", "found", "allowed", "p-value", "what")
_NUMBERS = slice(3, 6)
_PULL_HEAD = ("zenith [deg]", "azimuth [deg]", "photons", "expected", "pull")


def report_text(report: VerifyReport, *, verbose: bool, only_failed: bool) -> str:
    """The report as text; unless `verbose`, checks that passed in several wavebands share one line."""
    checks = [c for c in report.checks if not (only_failed and c.passed)]
    rows = [_row(check) for check in checks] if verbose else list(_short_rows(checks))
    tested = {row[0] for row in rows if any(row[_NUMBERS])}
    parts = ([row for row in rows if row[0] not in tested], [row for row in rows if row[0] in tested])
    lines = ["\n\n".join(_check_table(part) for part in parts if part or not rows)]
    lines += [f"note: {note}" for note in report.notes if not only_failed]
    for pulls in report.failed_pulls:
        lines += ["", f"waveband {pulls.waveband}, zones with the largest differences:", _pull_table(pulls)]
    failed = sum(not check.passed for check in report.checks)
    tests = sum(check.p_value is not None for check in report.checks)
    level = (
        f"{tests} tests at {report.level:.3g} each, {report.family_level:g} together"
        if tests
        else "bits compared, no statistical tests"
    )
    outcome = "all checks passed" if not failed else f"{failed} of {len(report.checks)} checks FAILED"
    return "\n".join([*lines, "", f"{outcome} ({level})"])


def _check_table(rows: list[tuple[str, ...]]) -> str:
    """Checks of bits, which have no numbers, or tests; without columns that are empty."""
    kept = [k for k, name in enumerate(_HEAD) if name not in _HEAD[_NUMBERS] or any(row[k] for row in rows)]
    return table([[row[k] for k in kept] for row in rows], [_HEAD[k] for k in kept], n_left=len(kept))


def _row(check: Check, wavebands: str | None = None) -> tuple[str, ...]:
    return (
        check.name,
        wavebands or ("" if check.waveband is None else str(check.waveband)),
        "ok" if check.passed else "FAILED",
        "" if check.found is None else f"{check.found:.6g}",
        "" if check.allowed is None else f"{check.allowed:.6g}",
        "" if check.p_value is None else f"{check.p_value:.3g}",
        check.detail,
    )


def _short_rows(checks: list[Check]) -> Iterator[tuple[str, ...]]:
    """One line for the checks of a name that passed in several wavebands, with their worst values."""
    for name in dict.fromkeys(check.name for check in checks):
        passed = [check for check in checks if check.name == name and check.passed]
        if len(passed) > 1:
            bounded = [check for check in passed if check.found is not None and check.allowed is not None]
            worst = max(bounded, key=lambda check: (check.found or 0.0) - (check.allowed or 0.0), default=passed[0])
            tested = [check for check in passed if check.p_value is not None or check.found is not None]
            detail = f"{passed[0].detail}; {len(passed) - 1} more"
            if tested:
                untested = len(passed) - len(tested)
                detail = f"of {len(passed)} the worst" + (f"; {untested} had too few photons" if untested else "")
            n_bands = len({check.waveband for check in passed} - {None})
            p_value = min((check.p_value for check in passed if check.p_value is not None), default=None)
            yield _row(dataclasses.replace(worst, p_value=p_value, detail=detail), f"{n_bands} bands")
        else:
            yield from map(_row, passed)
        yield from (_row(check) for check in checks if check.name == name and not check.passed)


def _pull_table(pulls: Pulls) -> str:
    rows = []
    for ring, column in pulls.worst():
        extents = (pulls.zones.zenith_bounds_deg[ring], pulls.zones.azimuth_bounds_deg[column])
        counts = (f"{values[ring, column]:.6g}" for values in (pulls.observed, pulls.expected))
        rows.append(
            [*(f"{low:.2f} to {high:.2f}" for low, high in extents), *counts, f"{pulls.pull[ring, column]:+.2f}"]
        )
    return table(rows, _PULL_HEAD, n_left=2)
