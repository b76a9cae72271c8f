"""Directions of photons against the sky that they come from: of our own runs and of any other code's."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, fields, replace
from functools import cache, partial

import numpy as np

from aomc_sky.component import Law
from aomc_sky.directions import Frame, sky_angles
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.outputs.photons.files import PhotonRows, in_order
from aomc_sky.plan.options import Placement
from aomc_sky.plan.streams import stream_key
from aomc_sky.system import n_cpus
from aomc_sky.verify import zone_tests
from aomc_sky.verify.counts import FAMILY_LEVEL
from aomc_sky.verify.inside import interior_of
from aomc_sky.verify.repeats import RepeatFinder, RepeatSample
from aomc_sky.verify.report import Against, Check, Pulls, VerifyReport, judged
from aomc_sky.verify.zones import MARGIN_DEG, ZoneShares, at_centres, choose_zones, zone_shares

LENGTH_TOLERANCE = 1e-5
"""How far the square of a direction's length may be from 1, as libmcpl has it."""

_ZENITH_DEG = 1e-3
"""Nearer to the zenith than this the azimuth means nothing and counts as 0."""


_LEAST_VARIANCE = 1e-9
"""Weights with a smaller relative variance count as equal."""


class Dependence(enum.Enum):
    """How photons depend on each other; the tests follow from it."""

    PLAN = "plan"  #: ours: the plan fixes how many come from each cell
    INDEPENDENT = "iid"  #: every photon is a draw of its own
    STRATIFIED = "stratified"  #: spread more evenly than chance, by a plan that is not known
    MIXED = "mixed"  #: between the last two: a merge of both, or a part of evenly spread photons


def verify_directions(
    source: PhotonSource,
    photons: Mapping[int, Iterable[PhotonRows]],
    *,
    dependence: Dependence = Dependence.PLAN,
    frame: Frame = Frame.UP,
    family_level: float = FAMILY_LEVEL,
    seed: int = 0,
    threads: int = 0,
) -> VerifyReport:
    """Test the photons of wavebands, in blocks of any order, against the sky of a source.

    `seed` is that of the thinning; 0 threads: one per CPU. Each waveband gets exact checks of every direction, and
    tests of zones of mu^2, of azimuth and of both, and of positions inside patches.
    """
    tests = DirectionTests(source, dependence=dependence, frame=frame, seed=seed)
    checks: list[Check] = []
    pulls: list[Pulls] = []
    for band, blocks in photons.items():
        band_checks, found = tests.checks(band, tests.count(band, blocks, threads))
        checks += band_checks
        pulls += [found] if found is not None else []
    return judged(checks, family_level=family_level, notes=tests.notes, pulls=pulls)


@dataclass(frozen=True, kw_only=True, slots=True)
class DirectionCounts:
    """Photons of a waveband; those of its blocks add up."""

    n: int
    zone_sums: (
        np.ndarray
    )  #: photons, those that thinning keeps, sums of weights and of their squares [shape (4, n_zone)]
    n_upward: int  #: that do not come from above
    n_bad_length: int  #: whose direction is not a unit vector
    n_dark: int  #: in zones that expect none, farther from their edges than rounding moves them
    n_negative: int  #: whose weight is below 0
    inside: np.ndarray  #: `PatchInterior.count`; empty where positions inside patches are not tested
    repeats: RepeatSample

    def __add__(self, other: DirectionCounts) -> DirectionCounts:
        names = (field.name for field in fields(self))
        return DirectionCounts(**{name: getattr(self, name) + getattr(other, name) for name in names})


class DirectionTests:
    """The tests of a source, prepared once for all its wavebands; `seed` is that of the thinning."""

    def __init__(self, source: PhotonSource, *, dependence: Dependence, frame: Frame = Frame.UP, seed: int = 0) -> None:
        self._source, self._dependence, self._frame = source, dependence, frame
        self._thinning_key = thinning_key(seed) if dependence is Dependence.STRATIFIED else None
        self.zones = choose_zones(source)
        self._shares_of_row = cache(partial(zone_shares, source, self.zones))
        self._interior, self._why_no_interior = interior_of(source)
        self._repeats = RepeatFinder.of(source.components, frame, is_centred=at_centres(source))

    @property
    def notes(self) -> list[str]:
        """Reasons for tests that are left out."""
        notes = [] if self._interior else [f"positions inside patches were not tested: {self._why_no_interior}"]
        if isinstance(self._repeats, str):
            notes.append(f"repeated photons were not looked for: {self._repeats}")
        return notes

    def _shares(self, band: int) -> ZoneShares:
        """The shares of the cells of a band in the zones."""
        return self._shares_of_row(band if self._source.bands_differ_inside_cells else 0)

    def count(self, band: int, blocks: Iterable[PhotonRows], threads: int = 0) -> DirectionCounts:
        """Count blocks on threads; the counts are the same on any number of them."""
        threads = threads or n_cpus()
        is_dark = self._shares(band).expected(self._cell_mass(band)) <= 0
        count = partial(self._count, is_dark=is_dark)
        total = count(PhotonRows(start=0, direction=np.zeros((0, 3))))
        with ThreadPoolExecutor(threads) as executor, closing(in_order(executor, threads, count, blocks)) as counted:
            for part in counted:
                total = total + part
        return total

    def _count(self, rows: PhotonRows, *, is_dark: np.ndarray) -> DirectionCounts:
        direction, n_zones = np.asarray(rows.direction, dtype=np.float64), self.zones.n_patches
        weight = np.ones(len(direction)) if rows.weight is None else np.asarray(rows.weight, dtype=np.float64)
        with np.errstate(over="ignore", invalid="ignore"):  # of damaged photons; they are counted as such
            is_unit = np.abs(np.sum(direction * direction, axis=1) - 1) <= LENGTH_TOLERANCE
            zenith, azimuth = (np.rad2deg(x) for x in sky_angles(direction, self._frame))
            azimuth[zenith < _ZENITH_DEG] = 0.0
            zone = self.zones.patch_of(zenith, azimuth)
            inside = np.zeros(0) if self._interior is None else self._interior.count(zenith, azimuth)
            repeats = RepeatSample() if isinstance(self._repeats, str) else self._repeats.sample(direction)
        kept = np.zeros(len(direction))
        if self._thinning_key is not None:
            kept = is_kept(self._thinning_key, rows.start, len(direction)).astype(np.float64)
        is_above = zone >= 0
        columns = (np.ones(len(direction)), kept, weight, weight * weight)
        zone_sums = np.stack([np.bincount(zone[is_above], x[is_above], n_zones) for x in columns])
        in_dark = np.flatnonzero(is_above & is_dark[zone])
        from_edge = self._from_edge_deg(zone[in_dark], zenith[in_dark], azimuth[in_dark])
        return DirectionCounts(
            n=len(direction),
            zone_sums=zone_sums,
            n_upward=int(np.count_nonzero(~is_above)),
            n_bad_length=int(np.count_nonzero(~is_unit)),
            n_dark=int(np.count_nonzero(from_edge > MARGIN_DEG)),
            n_negative=int(np.count_nonzero(weight < 0)),
            inside=inside,
            repeats=repeats,
        )

    def _from_edge_deg(self, zone: np.ndarray, zenith: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        """How far photons are from the nearest edge of their zones, (n,). [deg]"""
        ring, column = np.divmod(zone, self.zones.n_azimuth)
        from_ring = np.abs(zenith[:, None] - self.zones.zenith_bounds_deg[ring]).min(axis=1)
        ends = azimuth[:, None] - self.zones.azimuth_bounds_deg[column]
        around = np.abs(ends - 360.0 * np.rint(ends / 360.0)).min(axis=1) * np.sin(np.deg2rad(zenith))
        return np.minimum(from_ring, around)

    def checks(self, band: int, counts: DirectionCounts) -> tuple[list[Check], Pulls | None]:
        """The checks of the counts of a waveband, and their map of pulls. Without a photon to test the map is None."""
        waveband, expected = band + 1, self._shares(band).expected(self._cell_mass(band))
        if counts.n == 0:  # a plan may want none, a file of another code then proves nothing
            is_planned = self._dependence is Dependence.PLAN
            detail = "none" if is_planned else "none: nothing was tested"
            return [Check(name="photons", waveband=waveband, passed=is_planned, detail=detail)], None
        checks = _exact_checks(counts, waveband)
        if not isinstance(self._repeats, str):
            checks.append(counts.repeats.check(waveband))
        n, _, weight, weight2 = (float(sums.sum()) for sums in counts.zone_sums)
        if counts.n_negative or (n and weight2 == 0):
            wrong = f"{counts.n_negative} of {counts.n} are below 0" if counts.n_negative else "none is above 0"
            return [*checks, Check(name="weights", waveband=waveband, passed=False, detail=wrong)], None
        if expected.sum() <= 0:
            detail = f"{counts.n} photons, but the waveband is dark"
            return [*checks, Check(name="the waveband has light", waveband=waveband, passed=False, detail=detail)], None
        if self._dependence is Dependence.PLAN:
            tests, pulls = self._plan_checks(band, counts, expected)
        elif n * weight2 > weight**2 * (1 + _LEAST_VARIANCE):
            tests, pulls = self._weight_checks(band, counts)
        else:
            tests, pulls = self._count_checks(band, counts, expected)
        return [*checks, *tests], pulls

    def _cell_mass(self, band: int) -> np.ndarray:
        if self._dependence is Dependence.PLAN:
            return self._source.counts[band].astype(np.float64)
        return self._source.launch(band)

    def _plan_checks(self, band: int, counts: DirectionCounts, expected: np.ndarray) -> tuple[list[Check], Pulls]:
        """Only positions in cells that zones cut are free: at most 1.5 times as uneven as independent ones.

        A tenth of the variance of independent photons is allowed besides, as in the chi-square per degree of freedom.
        """
        options, waveband, zones, photons = self._source.plan.options, band + 1, self.zones, counts.zone_sums[0]
        cell_mass, shares = self._cell_mass(band), self._shares(band)
        checks = zone_tests.by_marginals(
            zones, zone_tests.even, photons, expected, shares.loose(cell_mass), waveband=waveband
        )
        # counts that were drawn are off the launch, not off themselves; photons off their counts show that first
        is_drawn = options["allocation"] == "multinomial" and all(check.passed for check in checks)
        launch = photons.sum() * shares.expected(self._source.launch(band))
        if options["method"] == "iid":
            checks += zone_tests.by_marginals(zones, zone_tests.independent, photons, launch, waveband=waveband)

        def variance(score: np.ndarray) -> float:
            own = float(score**2 @ expected)
            return zone_tests.RESONANCE * shares.variance(cell_mass, score) + zone_tests.MAX_PER_DEGREE * own

        checks += zone_tests.share_checks(zones, photons, expected, variance, waveband)
        checks += self._inside(counts, waveband, are_independent=options["placement"] == Placement.PHILOX.value)
        if is_drawn:
            return checks, self._pulls(waveband, photons, launch)
        return checks, replace(self._pulls(waveband, photons, expected), against=Against.PLAN)

    def _count_checks(self, band: int, counts: DirectionCounts, share: np.ndarray) -> tuple[list[Check], Pulls]:
        waveband, zones, (photons, kept) = band + 1, self.zones, counts.zone_sums[:2]
        scale = photons.sum() / share.sum()
        expected, cell_mass = scale * share, scale * self._source.launch(band)

        def variance(score: np.ndarray) -> float:
            own = float(score**2 @ expected)
            if self._dependence is not Dependence.STRATIFIED:
                return own
            resonant = zone_tests.RESONANCE * self._shares(band).variance(cell_mass, score)
            return (own + resonant) / 4  # a random half is kept

        if self._dependence is Dependence.STRATIFIED:
            loose = self._shares(band).loose(cell_mass)
            checks = zone_tests.by_marginals(zones, zone_tests.thinned, kept, expected, loose, waveband=waveband)
            checks += zone_tests.share_checks(zones, kept, expected / 2, variance, waveband)
        else:
            test = partial(zone_tests.independent, is_mixed=self._dependence is Dependence.MIXED)
            checks = zone_tests.by_marginals(zones, test, photons, expected, waveband=waveband)
            checks += zone_tests.share_checks(zones, photons, expected, variance, waveband)
        checks += self._inside(counts, waveband, are_independent=self._dependence is Dependence.INDEPENDENT)
        return checks, self._pulls(waveband, photons, expected)

    def _weight_checks(self, band: int, counts: DirectionCounts) -> tuple[list[Check], Pulls]:
        waveband, zones, (weight, weight2) = band + 1, self.zones, counts.zone_sums[2:]
        mass, is_mu = self._source.mass(band), self._source.plan.law == Law.CELL_MU
        # flux through the horizontal: photons uniform in solid angle times their cosine
        flux = np.where(is_mu, mass * self._source.cell_moments(band)[0], mass)
        share = zone_shares(self._source, zones, band, is_flux=True).expected(flux)
        share /= share.sum()
        expected = share * weight.sum()
        test = partial(zone_tests.weighted, is_mixed=self._dependence is not Dependence.INDEPENDENT)
        checks = zone_tests.by_marginals(zones, test, weight, weight2, share, waveband=waveband)
        checks += zone_tests.share_checks(
            zones,
            weight,
            expected,
            lambda score: float(score**2 @ weight2),
            waveband,
            photons_per_unit=float(weight.sum() / weight2.sum()),
        )
        return checks, self._pulls(waveband, weight, expected, expected * float(weight2.sum() / weight.sum()))

    def _inside(self, counts: DirectionCounts, waveband: int, *, are_independent: bool) -> list[Check]:
        if self._interior is None:
            return []
        return self._interior.checks(counts.inside, waveband, are_independent=are_independent)

    def _pulls(
        self, waveband: int, found: np.ndarray, expected: np.ndarray, variance: np.ndarray | None = None
    ) -> Pulls:
        shape = self.zones.n_zenith, self.zones.n_azimuth
        maps = (x.reshape(shape) for x in (found, expected, expected if variance is None else variance))
        observed, mean, spread = maps
        return Pulls(waveband=waveband, zones=self.zones, observed=observed, expected=mean, variance=spread)


def _exact_checks(counts: DirectionCounts, waveband: int) -> list[Check]:
    """The checks that every photon must pass."""
    checks = []
    for name, n_wrong, advice in (
        ("directions are unit vectors", counts.n_bad_length, ""),
        ("photons come from above", counts.n_upward, ": does z point the other way in this file? (--frame)"),
        ("no photon from dark zones", counts.n_dark, ""),
    ):
        wrong = f"{n_wrong} of {counts.n} are wrong" + (advice if n_wrong == counts.n else "")
        check = Check(name=name, waveband=waveband, passed=n_wrong == 0, found=float(n_wrong), allowed=0.0)
        checks.append(replace(check, detail=wrong if n_wrong else f"{counts.n} photons"))
    checks[-1] = replace(checks[-1], is_of_zones=True)
    return checks


def thinning_key(seed: int) -> int:
    """Key of the random choice of the photons that thinning keeps; no photon is made from it."""
    return stream_key(seed, "verify-coin")


def is_kept(key: int, start: int, n: int) -> np.ndarray:
    """Whether photons [start, start + n) are kept: each with a chance of one half.

    Bit i of the words of Philox4x64-10 by a key from `thinning_key`: any split of a file keeps the same photons.
    """
    step, offset = divmod(start, 256)  # numpy's Philox gives four words of 64 bits for each value of its counter
    generator = np.random.Philox(key=[key, 0], counter=[step, 0, 0, 0])
    words = np.asarray(generator.random_raw((offset + n + 63) // 64), dtype="<u8")
    return np.unpackbits(words.view(np.uint8), bitorder="little")[offset : offset + n].view(bool)
