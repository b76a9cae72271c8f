"""Directions of photons against the sky they come from: of our own runs and of any other code's."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Law
from aomc_sky.directions import Frame
from aomc_sky.source.irradiance import cell_moments
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.options import Placement
from aomc_sky.verify.report import Against, Check, Pulls
from aomc_sky.verify.sky import zone_tests
from aomc_sky.verify.sky.direction_counts import DirectionCounter, DirectionCounts, PhotonBlock, thinning_key
from aomc_sky.verify.sky.patches import PatchFinder, PatchInterior, interior_checks, interior_of, zone_of_patches
from aomc_sky.verify.sky.repeats import RepeatFinder
from aomc_sky.verify.sky.zones import choose_zones, zone_shares

#: Photons that a cell expects at least for its pull to say something.
LEAST_EXPECTED = 20.0
_OTHER_FRAME = ": does z point the other way in this file? (--frame)"


class Tied(enum.Enum):
    """How photons are tied together, which settles the tests.

    PLAN
        Ours: the plan fixes how many come from each cell.
    INDEPENDENT
        Every photon is a draw of its own.
    STRATIFIED
        Spread more evenly than chance, by a plan that is not known.
    MIXED
        Something between the last two: a merge of both, or a part of evenly spread photons.
    """

    PLAN = "plan"
    INDEPENDENT = "iid"
    STRATIFIED = "stratified"
    MIXED = "mixed"


class DirectionTests:
    """The tests of a source, prepared once for all its wavebands.

    `seed` is that of the thinning. `is_ours`: the photons come from files of a run, whose content is hashed; then
    copies are not looked for.
    """

    def __init__(
        self,
        source: PhotonSource,
        *,
        tied: Tied,
        frame: Frame = Frame.UP,
        seed: int = 0,
        threads: int = 0,
        is_ours: bool = False,
    ) -> None:
        self._source, self._tied, self._frame, self._seed, self._threads = source, tied, frame, seed, threads
        self.zones = choose_zones(source)
        self._finder = PatchFinder(self.zones)
        self._shares = zone_shares(source, self.zones)
        self._interior, self._why_no_interior = interior_of(source)
        at_centres = source.plan.options["placement"] == Placement.CENTRE.value
        self._repeats = "" if is_ours else RepeatFinder.of(source.components, frame, at_centres=at_centres)
        self._zone_of_patch = None if self._interior is None else zone_of_patches(self.zones, self._interior.grid)

    @property
    def notes(self) -> list[str]:
        """What is not tested."""
        notes = [] if self._interior else [f"positions inside patches were not tested: {self._why_no_interior}"]
        if isinstance(self._repeats, str) and self._repeats:
            notes.append(f"repeated photons were not looked for: {self._repeats}")
        return notes

    def checks(self, band: int, blocks: Iterable[PhotonBlock]) -> tuple[list[Check], Pulls | None]:
        """Test the photons of one waveband, in any order; its map is None where there is no photon.

        Blocks are photons, or what reads them on the threads that count them.
        """
        of_cells = self._of_cells(band)
        expected = self._shares.expected(of_cells)
        counter = DirectionCounter(
            zones=self._finder,
            is_dark=expected <= 0,
            interior=self._interior,
            frame=self._frame,
            zone_of_patch=self._zone_of_patch,
            thinning_key=thinning_key(self._seed) if self._tied is Tied.STRATIFIED else None,
            repeats=None if isinstance(self._repeats, str) else self._repeats,
        )
        counts = counter.count_all(blocks, self._threads)
        checks = _sound(counts, band + 1)
        if counts.repeats is not None:
            checks.append(counts.repeats.check(band + 1))
        if counts.n == 0:
            return [_nobody(band + 1, is_planned=self._tied is Tied.PLAN)], None
        if min(counts.weight_range) < 0 or counts.weight_range[1] == 0:
            return [*checks, _wrong_weights(counts, band + 1)], None
        if expected.sum() <= 0:
            return [*checks, _in_the_dark(counts, band + 1)], None
        if self._tied is Tied.PLAN:
            tests, pulls = self._of_plan(band, counts, of_cells, expected)
        elif counts.weights_differ:
            tests, pulls = self._of_weights(band, counts)
        else:
            tests, pulls = self._of_counts(band, counts, expected)
        return [*checks, *tests], pulls

    def _of_cells(self, band: int) -> np.ndarray:
        if self._tied is Tied.PLAN:
            return self._source.counts[band].astype(np.float64)
        return self._source.mass(band)

    def _of_plan(
        self, band: int, counts: DirectionCounts, of_cells: np.ndarray, expected: np.ndarray
    ) -> tuple[list[Check], Pulls]:
        options, waveband = self._source.plan.options, band + 1
        loose = self._shares.loose(of_cells)
        checks = zone_tests.by_marginals(self.zones, zone_tests.even, counts.zone, expected, loose, waveband=waveband)
        # counts that were drawn are off the masses, not off themselves; photons off their counts show that first
        is_drawn = options["allocation"] == "multinomial" and all(check.passed for check in checks)
        masses = counts.zone.sum() * self._shares.expected(self._source.mass(band))
        if options["method"] == "iid":
            checks += zone_tests.by_marginals(
                self.zones, zone_tests.independent, counts.zone, masses, waveband=waveband
            )
        checks += zone_tests.scores_of_plan(self.zones, counts.zone, self._shares, of_cells, waveband)
        is_jitter = options["placement"] == Placement.PHILOX.value
        checks += self._inside(counts, waveband, are_independent=is_jitter)
        reference, against = (masses, Against.MASSES) if is_drawn else (expected, Against.PLAN)
        return checks, self._pulls(waveband, counts.zone, reference, reference, against)

    def _of_counts(self, band: int, counts: DirectionCounts, share: np.ndarray) -> tuple[list[Check], Pulls]:
        waveband, expected = band + 1, counts.zone.sum() * share / share.sum()
        is_independent = self._tied is Tied.INDEPENDENT
        if self._tied is not Tied.STRATIFIED:
            test = partial(zone_tests.independent, is_mixed=not is_independent)
            checks = zone_tests.by_marginals(self.zones, test, counts.zone, expected, waveband=waveband)
            checks += zone_tests.scores_of_independent(self.zones, counts.zone, expected, waveband)
        else:
            of_cells = self._source.mass(band) * (counts.zone.sum() / share.sum())
            loose = self._shares.loose(of_cells)
            checks = zone_tests.by_marginals(
                self.zones, zone_tests.thinned, counts.kept, expected, loose, waveband=waveband
            )
            checks += zone_tests.scores_of_thinned(self.zones, counts.kept, self._shares, of_cells, waveband)
        checks += self._inside(counts, waveband, are_independent=is_independent)
        return checks, self._pulls(waveband, counts.zone, expected, expected)

    def _of_weights(self, band: int, counts: DirectionCounts) -> tuple[list[Check], Pulls]:
        share = zone_shares(self._source, self.zones, is_flux=True).expected(self._flux(band))
        share /= share.sum()
        test = partial(zone_tests.weighted, is_mixed=self._tied is not Tied.INDEPENDENT)
        checks = zone_tests.by_marginals(self.zones, test, counts.weight, counts.weight2, share, waveband=band + 1)
        checks += zone_tests.scores_of_weights(self.zones, counts.weight, counts.weight2, share, band + 1)
        expected = share * counts.weight.sum()
        mean = counts.weight2.sum() / counts.weight.sum()
        return checks, self._pulls(band + 1, counts.weight, expected, expected * mean)

    def _flux(self, band: int) -> np.ndarray:
        """Flux of each cell through the horizontal, any scale: photons uniform in solid angle times their cosine."""
        mass = self._source.mass(band)
        is_mu = self._source.plan.arrays["law"] == Law.CELL_MU
        return np.where(is_mu, mass * cell_moments(self._source.components)[0], mass)

    def _inside(self, counts: DirectionCounts, waveband: int, *, are_independent: bool) -> list[Check]:
        interior: PatchInterior | None = self._interior
        if interior is None or counts.interior is None:
            return []
        return interior_checks(interior, counts.interior, waveband, are_independent=are_independent)

    def _pulls(
        self,
        waveband: int,
        found: np.ndarray,
        expected: np.ndarray,
        variance: np.ndarray,
        against: Against = Against.MASSES,
    ) -> Pulls:
        shape = self.zones.n_zenith, self.zones.n_azimuth
        found, expected, variance = (x.reshape(shape) for x in (found, expected, variance))
        pull = pull_map(found, expected, variance=variance)
        return Pulls(waveband=waveband, zones=self.zones, observed=found, expected=expected, pull=pull, against=against)


def _sound(counts: DirectionCounts, waveband: int) -> list[Check]:
    """Exact checks that every photon must pass."""
    return [
        _none("directions are unit vectors", counts.n_bad_length, counts.n, waveband),
        _none("photons come from above", counts.n_upward, counts.n, waveband, advice=_OTHER_FRAME),
        _none("no photon from dark zones", counts.n_dark, counts.n, waveband, is_of_zones=True),
    ]


def _nobody(waveband: int, *, is_planned: bool) -> Check:
    """Of a waveband without photons: a plan may want none, a file of another code then proves nothing."""
    detail = "none" if is_planned else "none: nothing was tested"
    return Check(name="photons", waveband=waveband, passed=is_planned, detail=detail)


def _wrong_weights(counts: DirectionCounts, waveband: int) -> Check:
    low, high = counts.weight_range
    detail = f"weights from {low:g} to {high:g}: none may be below 0, and one at least must be above 0"
    return Check(name="weights", waveband=waveband, passed=False, found=low, allowed=0.0, detail=detail)


def _none(name: str, n_wrong: int, n: int, waveband: int, *, is_of_zones: bool = False, advice: str = "") -> Check:
    wrong = f"{n_wrong} of {n} are wrong" + (advice if n_wrong == n else "")
    return Check(
        name=name,
        waveband=waveband,
        passed=n_wrong == 0,
        found=float(n_wrong),
        allowed=0.0,
        detail=wrong if n_wrong else f"{n} photons",
        is_of_zones=is_of_zones,
    )


def _in_the_dark(counts: DirectionCounts, waveband: int) -> Check:
    return Check(
        name="the waveband has light",
        waveband=waveband,
        passed=False,
        detail=f"{counts.n} photons, but the waveband is dark",
    )


def pull_map(observed: ArrayLike, expected: ArrayLike, *, variance: ArrayLike | None = None) -> np.ndarray:
    """Return (observed - expected) / sqrt(variance) of every cell: independent photons give a normal law of variance 1.

    The variance is that of independent photons, `expected`, by default. NaN where it is below `LEAST_EXPECTED`, so that
    a cell expects too little to say; +inf where a cell that expects nothing holds something.
    """
    counts, mean = np.asarray(observed, dtype=np.float64), np.asarray(expected, dtype=np.float64)
    spread = mean if variance is None else np.asarray(variance, dtype=np.float64)
    pulls = np.full(counts.shape, np.nan)
    enough = spread >= LEAST_EXPECTED
    pulls[enough] = (counts[enough] - mean[enough]) / np.sqrt(spread[enough])
    pulls[(mean == 0) & (counts > 0)] = np.inf
    return pulls
