"""Photons that another code made, tested against the sky of a scene."""

from __future__ import annotations

from dataclasses import dataclass

from aomc_sky.directions import Frame
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.verify.counts import FAMILY_LEVEL
from aomc_sky.verify.directions import DirectionTests, Tied
from aomc_sky.verify.photon_file import PhotonFile
from aomc_sky.verify.report import Check, Pulls, VerifyReport, judged


@dataclass(frozen=True, kw_only=True, slots=True)
class PhotonTestOptions:
    """How photons of another code are tested.

    Parameters
    ----------
    tied : Tied
        `Tied.INDEPENDENT`, or `Tied.STRATIFIED` for photons that are spread more evenly than chance.
    frame : Frame
        Which way z grows in their directions.
    family_level : float
        Chance that correct photons fail any test. [above 0, below 1]
    seed : int
        Of the fair coin that thins stratified photons. [0 to 2^64 - 1]
    threads : int
        0 for one per CPU.
    """

    tied: Tied = Tied.INDEPENDENT
    frame: Frame = Frame.UP
    family_level: float = FAMILY_LEVEL
    seed: int = 0
    threads: int = 0


def verify_photons(source: PhotonSource, photons: PhotonFile, options: PhotonTestOptions) -> VerifyReport:
    """Test photons against the sky of a scene.

    Parameters
    ----------
    source : PhotonSource
        Of the scene; its masses are what counts, not its photons.
    photons : PhotonFile
        From `aomc_sky.verify.photon_file.open_photons`.
    options : PhotonTestOptions
        How.

    Returns
    -------
    VerifyReport
        Of each waveband of the file: exact checks of every direction, zones of mu^2, of azimuth and of both, and
        places inside patches.

    Raises
    ------
    InputFileError
        A record of the file cannot be read.
    """
    tests = DirectionTests(source, tied=options.tied, frame=options.frame, seed=options.seed, threads=options.threads)
    checks: list[Check] = []
    pulls: list[Pulls] = []
    for band in photons.bands:
        of_band, found = tests.checks(band, photons.rows(band))
        checks += of_band
        pulls += [found] if found is not None else []
    notes = [*photons.notes, *tests.notes]
    return judged(checks, family_level=options.family_level, notes=notes, pulls=pulls)
