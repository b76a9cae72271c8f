"""Photons that another code made, tested against the sky of a scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from aomc_sky.directions import Frame
from aomc_sky.kernels.backend import announce_photons
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.verify.counts import FAMILY_LEVEL
from aomc_sky.verify.foreign.origin import Origin
from aomc_sky.verify.foreign.photon_file import PhotonFile
from aomc_sky.verify.report import Check, Pulls, VerifyReport, judged
from aomc_sky.verify.sky.direction_counts import PhotonRows
from aomc_sky.verify.sky.directions import DirectionTests, Tied

_PACKED = {"float32": 6e-7, "float64": 1.4e-15}
"""What packing may change a component by (docs/formats/mcpl.md)."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonTestOptions:
    """How photons of another code are tested."""

    #: `Tied.INDEPENDENT`, or `Tied.STRATIFIED` for photons that are spread more evenly than chance.
    tied: Tied = Tied.INDEPENDENT
    #: Which way z grows in their directions.
    frame: Frame = Frame.UP
    #: Chance that correct photons fail any test. [above 0, below 1]
    family_level: float = FAMILY_LEVEL
    #: Of the fair coin that thins stratified photons. [0 to 2^64 - 1]
    seed: int = 0
    #: 0 for one per CPU.
    threads: int = 0


def verify_photons(
    source: PhotonSource, photons: PhotonFile, options: PhotonTestOptions, origin: Origin | None = None
) -> VerifyReport:
    """Test photons against the sky of a scene, whose masses count, not its photons.

    Of each waveband of the file: exact checks of every direction, zones of mu^2, of azimuth and of both, and positions
    inside patches. The plan of `origin`, what the file says of itself, takes the place of `source`, its `tied` that of
    the options.
    """
    known = Origin(tied=options.tied) if origin is None else origin
    tests = DirectionTests(
        known.plan or source, tied=known.tied, frame=options.frame, seed=options.seed, threads=options.threads
    )
    checks: list[Check] = []
    pulls: list[Pulls] = []
    for band in photons.bands:
        again = None if known.plan is None else MadeAgain(known.plan, band)
        rows = photons.rows(band) if again is None else again.compared(photons.rows(band))
        of_band, found = tests.checks(band, rows)
        checks += of_band if again is None else [again.check(), *of_band]
        pulls += [found] if found is not None else []
    notes = [*photons.notes, *known.notes, *tests.notes]
    report = judged(checks, family_level=options.family_level, notes=notes, pulls=pulls)
    return replace(report, notes=(*report.notes, *_too_even(report)))


class MadeAgain:
    """The photons of a waveband of a plan, made again and compared with those of a file."""

    def __init__(self, source: PhotonSource, band: int) -> None:
        self._source, self._band = source, band
        self._n, self._n_wrong, self._first = 0, 0, -1
        announce_photons(source.n_photons(band))

    def compared(self, blocks: Iterable[PhotonRows]) -> Iterator[PhotonRows]:
        """The same blocks, compared on the way."""
        tolerance = _PACKED[self._source.dtype.name]
        for rows in blocks:
            expected = self._source.photons(self._band, rows.start, rows.start + len(rows.direction)).directions
            is_right = np.all(np.abs(rows.direction - expected) <= tolerance, axis=1)
            wrong = np.flatnonzero(~is_right)
            if wrong.size and self._first < 0:
                self._first = rows.start + int(wrong[0])
            self._n, self._n_wrong = self._n + len(is_right), self._n_wrong + wrong.size
            yield rows

    def check(self) -> Check:
        """What was found, after all blocks."""
        detail = f"all {self._n} are those of the plan"
        if self._n_wrong:
            detail = f"{self._n_wrong} of {self._n} are not those of the plan; the first is photon {self._first}"
        return Check(
            name="photons made again",
            waveband=self._band + 1,
            passed=self._n_wrong == 0,
            found=float(self._n_wrong),
            allowed=0.0,
            detail=detail,
        )


def _too_even(report: VerifyReport) -> list[str]:
    """A sentence where tests for independent photons failed only from below."""
    even = [check for check in report.checks if check.is_even and not check.passed]
    if not even:
        return []
    worst = min(even, key=lambda check: (check.p_value or 0.0, check.found or 0.0))
    band = "" if worst.waveband is None else f" of waveband {worst.waveband}"
    return [
        f"{len(even)} of the tests failed because photons are spread more evenly than independent ones can be "
        f"({worst.name}{band}: {worst.detail}); if their sampler stratifies or takes low-discrepancy numbers, write "
        "--method stratified"
    ]
