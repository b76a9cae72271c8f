"""What ``verify`` prints and draws: a table of checks, and where the photons of a failed test lie off."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from aomc_sky.cli.table import table

if TYPE_CHECKING:
    from aomc_sky.verify.report import Check, Pulls, VerifyReport

_HEAD = ("check", "waveband", "outcome", "found", "allowed", "p-value", "what")
_PULL_HEAD = ("zenith [deg]", "azimuth [deg]", "photons", "expected", "pull")


def report_text(report: VerifyReport, picture: str | None, *, verbose: bool, only_failed: bool) -> str:
    """The whole text.

    Parameters
    ----------
    report : VerifyReport
        What was found.
    picture : str or None
        Where the map of pulls was drawn.
    verbose : bool
        A line for every check of every waveband; otherwise checks that passed in several wavebands share one.
    only_failed : bool
        Leave out what passed.
    """
    checks = [c for c in report.checks if not (only_failed and c.passed)]
    rows = [_row(check) for check in checks] if verbose else list(_short_rows(checks))
    lines = [table(rows, _HEAD, n_left=len(_HEAD), n_keys=2)]
    lines += [f"note: {note}" for note in [*report.notes, *_not_looked_at(report)] if not only_failed]
    for pulls in report.failed_pulls:
        lines += ["", f"waveband {pulls.waveband}, zones that are farthest off:", _pull_table(pulls)]
    if picture:
        lines.append(f"map of pulls: {picture}")
    lines += ["", _verdict(report)]
    return "\n".join(lines)


def _not_looked_at(report: VerifyReport) -> list[str]:
    """Which blocks were made again, and what no check says."""
    lines = []
    if report.block_seed is not None:
        lines.append(f"blocks to make again were drawn with --seed {report.block_seed}")
    if report.unvouched:
        lines.append(f"not vouched for: {'; '.join(report.unvouched)}")
    return lines


def _verdict(report: VerifyReport) -> str:
    failed = sum(not check.passed for check in report.checks)
    tests = sum(check.p_value is not None for check in report.checks)
    level = f"{tests} tests at {report.level:.3g} each, {report.family_level:g} together" if tests else "no tests"
    outcome = "all checks passed" if not failed else f"{failed} of {len(report.checks)} checks FAILED"
    return f"{outcome} ({level})"


def _row(check: Check) -> tuple[str, ...]:
    return (
        check.name,
        "" if check.waveband is None else str(check.waveband),
        "ok" if check.passed else "FAILED",
        "" if check.found is None else f"{check.found:.6g}",
        "" if check.allowed is None else f"{check.allowed:.6g}",
        "" if check.p_value is None else f"{check.p_value:.3g}",
        check.detail,
    )


def _short_rows(checks: Iterable[Check]) -> Iterable[tuple[str, ...]]:
    """Checks of one name that passed in several wavebands in one line, with their worst values."""
    by_name: dict[str, list[Check]] = {}
    for check in checks:
        by_name.setdefault(check.name, []).append(check)
    for name, same in by_name.items():
        passed = [check for check in same if check.passed]
        if len(passed) > 1:
            yield _together(name, passed)
        else:
            yield from map(_row, passed)
        yield from (_row(check) for check in same if not check.passed)


def _together(name: str, checks: list[Check]) -> tuple[str, ...]:
    p_values = [check.p_value for check in checks if check.p_value is not None]
    bounded = [check for check in checks if check.found is not None and check.allowed is not None]
    worst = max(bounded, key=lambda check: (check.found or 0.0) - (check.allowed or 0.0), default=None)
    untested = sum(check.p_value is None and check.found is None for check in checks)
    what = f"of {len(checks)} the worst" if p_values or worst is not None else ""
    if untested and untested < len(checks):
        what += f"; {untested} had too few photons"
    elif untested:
        what = f"{checks[0].detail}; {len(checks) - 1} more"
    return (
        name,
        _span([check.waveband for check in checks]),
        "ok",
        "" if worst is None else f"{worst.found:.6g}",
        "" if worst is None else f"{worst.allowed:.6g}",
        f"{min(p_values):.3g}" if p_values else "",
        what,
    )


def _span(wavebands: list[int | None]) -> str:
    known = sorted({w for w in wavebands if w is not None})
    if not known:
        return ""
    is_run = known[-1] - known[0] + 1 == len(known)
    return str(known[0]) if len(known) == 1 else f"{known[0]}-{known[-1]}" if is_run else f"{len(known)} bands"


def _pull_table(pulls: Pulls) -> str:
    rows = []
    for ring, column in pulls.worst():
        zenith, azimuth = pulls.zones.zenith_bounds_deg[ring], pulls.zones.azimuth_bounds_deg[column]
        rows.append(
            (
                f"{zenith[0]:.2f} to {zenith[1]:.2f}",
                f"{azimuth[0]:.2f} to {azimuth[1]:.2f}",
                f"{pulls.observed[ring, column]:.6g}",
                f"{pulls.expected[ring, column]:.6g}",
                f"{pulls.pull[ring, column]:+.2f}",
            )
        )
    return table(rows, _PULL_HEAD, n_left=2, n_keys=2)


def draw_pulls(report: VerifyReport, target: Path, *, title: str) -> None:
    """Draw the maps of pulls of the wavebands that failed, 12 spread over them where there are more.

    Raises
    ------
    UsageError
        The suffix is none of a picture.
    MissingExtraError
        matplotlib is not installed.
    OutputError
        The file cannot be written.
    """
    from aomc_sky.outputs.picture import picture_path, save_picture
    from aomc_sky.pictures.drawing.panels import figure_of
    from aomc_sky.pictures.pull import pull_picture

    path = picture_path(target)
    maps = [(f"waveband {pulls.waveband}", pulls.zones, pulls.pull) for pulls in report.failed_pulls]
    figure = figure_of(pull_picture(maps, title=title))
    save_picture(figure, path, dpi=figure.dpi)
