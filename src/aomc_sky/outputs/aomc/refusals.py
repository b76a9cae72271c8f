"""Why the AOMC program cannot take a run: every reason at once, and the shortest command that cures them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.errors import AllocationError, SceneError
from aomc_sky.outputs.aomc.values import MOST_PHOTONS
from aomc_sky.outputs.beam_direction import beam_direction_deg

LAST_ZENITH_DEG = 89


@dataclass(frozen=True, kw_only=True, slots=True)
class Refusal:
    """A reason, and what cures it: options of `run`, options of `export`, or something that a person does."""

    reason: str
    run: str = ""
    export: str = ""
    by_hand: str = ""
    is_allocation: bool = False


def raise_all(refusals: Sequence[Refusal], *, scene: str = "AMC_INP", run: str = "RUN") -> None:
    """Raise one error with all reasons; `scene` and `run` are what the user would write."""
    if not refusals:
        return
    reasons = [refusal.reason for refusal in refusals]
    text = reasons[0] if len(reasons) == 1 else "; ".join(f"({k}) {r}" for k, r in enumerate(reasons, start=1))
    text += f". Cure: {_cure(refusals, scene, run)}"
    error = AllocationError if all(refusal.is_allocation for refusal in refusals) else SceneError
    raise error(text)


def _cure(refusals: Sequence[Refusal], scene: str, run: str) -> str:
    by_hand, again, export = (
        list(dict.fromkeys(filter(None, words)))  # each once, in order
        for words in zip(*((r.by_hand, r.run, r.export) for r in refusals), strict=True)
    )
    steps = list(by_hand)
    if again or (by_hand and not export):
        options = "".join(f" {words}" for words in again)
        steps.append(f"aomc-sky run {scene}{options} --out NEW, with the other options of this run")
    if export or again or by_hand:
        options = "".join(f" {words}" for words in export)
        steps.append(f"aomc-sky export {'NEW' if again or by_hand else run} --to aomc{options}")
    return "; then ".join(steps)


def photon_refusals(n_photons: dict[int, int]) -> list[Refusal]:
    """No photons at all, or too many; `n_photons` of each waveband that has any. [0-based]"""
    if not n_photons:
        return [
            Refusal(
                reason="no waveband of this run has photons, so there is nothing to export",
                run="--iterations 1000000",
            )
        ]
    band, most = max(n_photons.items(), key=lambda item: item[1])
    if most <= MOST_PHOTONS:
        return []
    return [
        Refusal(
            reason=f"waveband {band + 1} has {most} photons; the AOMC program counts in 32-bit floats, and up to "
            f"{MOST_PHOTONS} per waveband come out exactly",
            run=f"--iterations {MOST_PHOTONS}",
            is_allocation=True,
        )
    ]


def component_refusals(parts: Iterable[tuple[Component, np.ndarray]]) -> list[Refusal]:
    """Components with photons, (n_band, n_cell) each, whose light has no place on whole degrees."""
    lit = [(component, int(counts.sum())) for component, counts in parts if counts.any()]
    found = [_beam_refusal(component, n) for component, n in lit if component.grid is None]
    return [refusal for refusal in found if refusal is not None]


def whole_degree(component: Component) -> tuple[int, int] | None:
    """The whole degrees that a beam comes from, None where it does not."""
    direction = beam_direction_deg(component)
    if direction is None or component.law is not Law.BEAM:
        return None
    zenith, azimuth = (round(angle) for angle in direction)
    is_there = 1 <= zenith <= LAST_ZENITH_DEG and np.allclose(direction, (zenith, azimuth), rtol=0, atol=1e-9)
    return (zenith, azimuth % 360) if is_there else None


def _beam_refusal(component: Component, n_photons: int) -> Refusal | None:
    if whole_degree(component) is not None:
        return None
    direction = beam_direction_deg(component)
    where, options, by_hand = "", "", ""
    if direction is not None:
        where = f" from zenith angle {direction[0]:g}, azimuth {direction[1]:g} degrees"
        zenith, azimuth = min(max(round(direction[0]), 1), LAST_ZENITH_DEG), round(direction[1]) % 360
        if not np.allclose(direction, (zenith, azimuth), rtol=0, atol=1e-9):
            options = f"--sun-zenith {zenith} --sun-azimuth {azimuth}"
    if component.law in (Law.DISC, Law.DISC_AT_HORIZON):
        where += ", with the disc of the sun"
        by_hand = "write disc = false in [sun] of sky.toml"
    if component.law.is_lobe:
        by_hand = "make a table of the lobes with aomc-sky lobes --write-skydist, and name it in the scene"
    return Refusal(
        reason=f"component {component.name!r} (law {component.law.name}) sends {n_photons} photons{where}; the AOMC "
        "program's sky file holds zenith angles of 1, 2 .. 89 degrees and whole azimuths",
        run=options,
        by_hand=by_hand,
    )


def wavelength_refusals(wavelength_nm: np.ndarray, bands: Iterable[int]) -> list[Refusal]:
    """Wavebands [0-based] that would not find their own sky."""
    single = wavelength_nm.astype(np.float32)
    return [
        _wavelength_refusal(wavelength_nm[band], band, int(np.count_nonzero(single == single[band]))) for band in bands
    ]


def _wavelength_refusal(wavelength_nm: float, band: int, n_equal: int) -> Refusal:
    named = f"waveband {band + 1} at {wavelength_nm:.9g} nm"
    if n_equal > 1:
        return Refusal(
            reason=f"{named} has the same wavelength as another one and different counts; the AOMC program chooses a "
            "sky by its wavelength",
            export=f"--waveband {band + 1}",
        )
    return Refusal(
        reason=f"{named} is too close to another one for the AOMC program's 32-bit floats to choose its own sky",
        by_hand="give the wavebands of lambbot.inp wavelengths at least 0.001 nm apart",
    )
