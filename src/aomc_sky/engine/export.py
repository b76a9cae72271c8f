"""``export``: other formats from the plan of a run, which needs no stored photons."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from aomc_sky.atomic_file import prepare_target
from aomc_sky.engine.stored_run import StoredRun
from aomc_sky.errors import ForeignOutputError, SceneError, UsageError
from aomc_sky.outputs.folder.run_folder import RunFolder, create_folder
from aomc_sky.outputs.photon_formats import SOURCE, SOURCE_FILE, photon_writer
from aomc_sky.outputs.photons.files import PhotonFiles, Progress, emit_photons, photon_files, require_space
from aomc_sky.outputs.photons.mcpl import McplWriter


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportOptions:
    """The format and the target of an export; they change no photon."""

    to: str  #: one of `EXPORTS`
    out: str | None = None  #: file or folder; `target_of` has the default
    wavebands: list[int] | None = None  #: only these [1-based]
    scene: str | None = None  #: amc.inp of the run's scene, for `aomc`
    threads: int = 0  #: 0 for one per CPU
    force: bool = False  #: replace what is there


@dataclass(frozen=True, kw_only=True, slots=True)
class _Job:
    """An export that is being made; `name` is that of its one file, or empty."""

    run: StoredRun
    options: ExportOptions
    bands: tuple[int, ...]
    folder: RunFolder
    name: str
    progress: Progress | None
    notes: list[str] = field(default_factory=list)
    launched: list[int] = field(default_factory=list)  #: photons of each waveband, where they are not the run's


def export_run(run: StoredRun, options: ExportOptions, progress: Progress | None = None) -> dict[str, Any]:
    """Write a run in another format and return what was written, as JSON values.

    The function `progress` is called with photons done and photons in all.

    ForeignOutputError if the target holds something else, SceneError if the format cannot hold the run.
    """
    started, target, bands = time.perf_counter(), target_of(run, options), run.chosen(options.wavebands)
    make, file_name = EXPORTS[options.to]
    folder, name = (target.parent, target.name) if file_name else (target, "")
    if not name and folder.resolve() == run.path.resolve():
        raise UsageError(f"--out {options.out} is the run itself; name another folder")
    job = _Job(run=run, options=options, bands=bands, folder=RunFolder(folder), name=name, progress=progress)
    if name:  # the others create their folder once the export is known to be possible
        if os.path.lexists(target) and not target.is_file():
            raise UsageError(f"--out {target} is a device, a pipe or a link to nothing; name a file")
        if target.is_symlink() and not options.force:
            raise ForeignOutputError(f"{target} is a link to another file; name that file, or add --force")
        create_folder(folder)
        prepare_target(target)
    names, was_finished = make(job)
    if options.to in _SCALAR and run.source.has_polarisation:
        job.notes.append(
            f"the light is polarised, and {options.to} has no Stokes vectors: its files have the radiance alone"
        )
    return {
        "to": options.to,
        "out": str(target),
        "plan_sha256": run.source.plan.sha256,
        "seed": run.source.plan.seed,
        "wavebands": [band + 1 for band in bands],
        "photons": sum(job.launched or [run.source.n_photons(band) for band in bands]),
        "files": {file: {"bytes": job.folder.size_of(file) or 0} for file in names},
        "notes": job.notes,
        "seconds": round(time.perf_counter() - started, 6),
        "was_finished": was_finished,
    }


def target_of(run: StoredRun, options: ExportOptions) -> Path:
    """File or folder of an export; the default is beside the run folder ``out``: ``out-npy``, ``out.mcpl``.

    For formats of one file, a name with another ending is a folder.
    """
    _, file_name = EXPORTS[options.to]
    suffix = Path(file_name).suffix
    if options.out is None:
        return run.path.with_name(run.path.name + (suffix or f"-{options.to}"))
    out = Path(options.out).absolute()
    if out.suffix.lower() == ".gz":
        raise UsageError(f"--out {options.out}: an export is not packed; write {out.stem} and run gzip on it")
    return out / file_name if file_name and (out.suffix != suffix or out.is_dir()) else out


def _export_mcpl(job: _Job) -> tuple[list[str], bool]:
    """One MCPL file."""
    (file,) = photon_files(job.folder, [McplWriter(job.run.source, job.name)], job.bands)
    if not job.options.force and job.folder.size_of(job.name) is not None:
        if file.missing:
            raise ForeignOutputError(_foreign(job))
        return [job.name], True
    _emit(job, [file])
    return [job.name], False


def _export_photons(job: _Job) -> tuple[list[str], bool]:
    """Photon files as a run writes them; complete files are kept."""
    source, force = job.run.source, job.options.force
    with job.folder.held(source.plan, force=force):
        files = photon_files(job.folder, [photon_writer(job.options.to)(source)], job.bands)
        missing = [file for file in files if force or file.missing]
        _emit(job, missing)
    return [layout.name for file in files for layout in file.layouts], not missing


def _emit(job: _Job, files: list[PhotonFiles]) -> None:
    bands = [band for file in files for band in file.bands]
    require_space(files)
    emit_photons(job.run.source, files, bands, job.options.threads, job.progress)


def _foreign(job: _Job) -> str:
    target = job.folder.path / job.name
    return f"{target} exists and holds something else; choose another --out, or add --force to replace it"


def _export_netcdf(job: _Job) -> tuple[list[str], bool]:
    from aomc_sky.outputs.tables.netcdf import plan_of_netcdf, write_netcdf

    target = job.folder.path / job.name
    if not job.options.force and job.folder.size_of(job.name) is not None:
        if plan_of_netcdf(target) != job.run.source.plan.sha256:
            raise ForeignOutputError(_foreign(job))
        return [job.name], True
    write_netcdf(job.run.source, target)
    return [job.name], False


def _export_source(job: _Job) -> tuple[list[str], bool]:
    data, size = job.run.source.to_bytes(), job.folder.size_of(job.name)
    if not job.options.force and size is not None:
        with job.folder.reading(job.name) as file:
            if size != len(data) or file.read(size) != data:
                raise ForeignOutputError(_foreign(job))
        return [job.name], True
    job.folder.write(job.name, data)
    return [job.name], False


def _export_envmap(job: _Job) -> tuple[list[str], bool]:
    from aomc_sky.outputs import envmap

    source, folder, n_bands = job.run.source, job.folder, len(job.bands)
    head, axes = envmap.head_of_map(n_bands), envmap.axes_text(source, job.bands)
    size = len(head) + 4 * n_bands * envmap.N_ROWS * envmap.N_COLUMNS
    with folder.held(source.plan, force=job.options.force):
        is_there = folder.holds(envmap.MAP, head, size) and folder.holds(envmap.AXES, axes, len(axes))
        if is_there and not job.options.force:
            return [envmap.MAP, envmap.AXES], True
        folder.require_space(size)
        with folder.stream(envmap.MAP) as file:
            file.write(head)
            for k, one in enumerate(envmap.maps(source, job.bands)):
                file.write(one.astype("<f4").tobytes())
                if job.progress is not None:
                    job.progress(k + 1, n_bands)
        folder.write(envmap.AXES, axes)
    return [envmap.MAP, envmap.AXES], False


def _export_aomc(job: _Job) -> tuple[list[str], bool]:
    from aomc_sky.outputs.aomc.skydist import aomc_sky, check_scene, water_note, write_aomc_folder

    source = job.run.source
    amc_inp = None if job.options.scene is None else Path(os.path.abspath(job.options.scene))
    if amc_inp is not None:
        amc_inp = amc_inp / "amc.inp" if amc_inp.is_dir() else amc_inp
        if not amc_inp.is_file():
            raise SceneError(f"{job.options.scene}: there is no amc.inp here")
        check_scene(amc_inp, source.plan.wavelength_nm)
        if amc_inp.parent.resolve() == job.folder.path.resolve():
            raise UsageError(f"{job.folder.path} holds the scene itself; choose another --out")
    sky = aomc_sky(source, job.bands)
    with job.folder.held(source.plan, force=job.options.force):
        names = write_aomc_folder(sky, job.folder, amc_inp)
    job.launched.extend(sky.counts.sum(axis=(1, 2)).tolist())
    job.notes.extend(sky.notes)
    if amc_inp is None:
        job.notes.append(
            "no scene was named: name it with --scene AMC_INP, which copies its files, or write "
            f"{sky.iterations} in line 1 of amc.inp and 1 in line 2"
        )
    job.notes.extend(filter(None, [water_note(job.folder)]))
    return names, False


_SCALAR = ("aomc", "envmap")
"""Formats of light without polarisation."""

EXPORTS: dict[str, tuple[Callable[[_Job], tuple[list[str], bool]], str]] = {
    "mcpl": (_export_mcpl, "photons.mcpl"),
    "npy": (_export_photons, ""),
    "csv": (_export_photons, ""),
    "netcdf": (_export_netcdf, "counts.nc"),
    "aomc": (_export_aomc, ""),
    "envmap": (_export_envmap, ""),
    SOURCE: (_export_source, SOURCE_FILE),
}
"""Format -> the function that writes it, and the name of its file (empty: the format is a folder)."""
