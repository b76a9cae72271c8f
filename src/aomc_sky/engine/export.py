"""``export``: other formats from the plan of a run, which needs no stored photons."""

from __future__ import annotations

import contextlib
import os
import time
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from aomc_sky.engine.export_formats import exports
from aomc_sky.engine.stored_run import StoredRun
from aomc_sky.errors import ForeignOutputError, SceneError, UsageError
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, photon_writer
from aomc_sky.outputs.photons.files import PhotonFiles, Progress, emit_photons, photon_files, require_space, total_size
from aomc_sky.outputs.photons.mcpl import McplWriter
from aomc_sky.outputs.run_folder import RunFolder, create_folder, is_run_file
from aomc_sky.system import appearing, prepare_target


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportOptions:
    """The format and the target of an export; they change no photon."""

    to: str  #: one of `exports`
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
    started, bands = time.perf_counter(), run.chosen(options.wavebands)
    folder, name = target_of(run, options)
    export, target = exports()[options.to], folder / name
    if (not name or options.to == "envmap") and folder.resolve() == run.path.resolve():
        raise UsageError(f"--out {options.out} is {'in ' if name else ''}the run itself", "name another folder")
    if is_run_file(name) and folder.resolve() == run.path.resolve():  # verify would take it for the run's
        raise UsageError(
            f"--out {options.out}: {target.name} in the run is the run's own", "name another file or folder"
        )
    job = _Job(run=run, options=options, bands=bands, folder=RunFolder(folder), name=name, progress=progress)
    if name:  # the others create their folder once the export is known to be possible
        if os.path.lexists(target) and not target.is_file():
            raise UsageError(f"--out {target} is a device, a pipe or a link to nothing", "name a file")
        if target.is_symlink() and not options.force:
            raise ForeignOutputError(f"{target} is a link to another file", "name that file, or add --force")
        create_folder(folder)
        prepare_target(target)
    module, _, function = export.make.partition(":")
    names, was_finished = getattr(import_module(module), function)(job)
    if export.is_scalar and run.source.has_polarisation:
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


def target_of(run: StoredRun, options: ExportOptions) -> tuple[Path, str]:
    """Folder of an export and the name of its one file, or no name where the folder is the export.

    The default is beside the run folder ``out``: ``out-npy``, ``out.mcpl``.
    """
    export = exports()[options.to]
    if options.out is None:
        ending = Path(export.file_name).suffix
        beside = run.path.with_name(run.path.name + (ending or f"-{options.to}"))
        return (beside.parent, beside.name) if ending else (beside, "")
    out = Path(options.out).absolute()
    ending, is_folder = out.suffix.lower(), out.is_dir()
    if ending == ".gz":
        raise UsageError(f"--out {options.out}: an export is not packed", f"write {out.stem} and run gzip on it")
    if ending in export.endings and not (is_folder and export.file_name):
        if is_folder:
            raise UsageError(f"--out {options.out} is a folder", f"name a file, for example {out.stem}-map{ending}")
        return out.parent, out.name
    if out.exists() and not is_folder:
        named = f", or a name that ends in {' or '.join(export.endings)}" if export.endings else ""
        raise UsageError(f"--out {options.out} is there and no folder; --to {options.to} takes a folder{named}")
    other_endings = {one for to in exports().values() for one in to.endings}
    other_endings |= {Path(photon_writer(one).names[0]).suffix for one in PHOTON_FORMATS}
    if ending in other_endings.difference(export.endings) or (ending and export.is_strict and not is_folder):
        endings = " or ".join(filter(None, [", ".join(export.endings[:-1]), *export.endings[-1:]]))
        named = f"a name that ends in {endings} is a file, and " if endings else ""
        raise UsageError(
            f"--out {options.out}: --to {options.to} writes no {ending} file; {named}a name without an ending, such as "
            f"{out.stem}, is a folder"
        )
    return out, export.file_name


def export_mcpl(job: _Job) -> tuple[list[str], bool]:
    """One MCPL file."""
    (file,) = photon_files(job.folder, [McplWriter(job.run.source, job.name)], job.bands)
    if not job.options.force and job.folder.size_of(job.name) is not None:
        if file.missing:
            raise ForeignOutputError(_foreign(job.folder.path / job.name))
        return [job.name], True
    _emit(job, [file])
    return [job.name], False


def export_photons(job: _Job) -> tuple[list[str], bool]:
    """Photon files as a run writes them; complete files are kept."""
    source, force = job.run.source, job.options.force
    files = photon_files(job.folder, [photon_writer(job.options.to)(source)], job.bands)
    with job.folder.held(source.plan, force=force, n_bytes=total_size(files)):
        missing = [file for file in files if force or file.missing]
        _emit(job, missing)
    return [layout.name for file in files for layout in file.layouts], not missing


def _emit(job: _Job, files: list[PhotonFiles]) -> None:
    bands = [band for file in files for band in file.bands]
    require_space(files)
    emit_photons(job.run.source, files, bands, job.options.threads, job.progress)


def _foreign(target: Path) -> str:
    return f"{target} exists and holds something else; choose another --out, or add --force to replace it"


def export_netcdf(job: _Job) -> tuple[list[str], bool]:
    """Counts and masses in one netCDF file."""
    from aomc_sky.outputs.tables.netcdf import plan_of_netcdf, write_netcdf

    target = job.folder.path / job.name
    if not job.options.force and job.folder.size_of(job.name) is not None:
        if plan_of_netcdf(target) != job.run.source.plan.sha256:
            raise ForeignOutputError(_foreign(job.folder.path / job.name))
        return [job.name], True
    write_netcdf(job.run.source, target)
    return [job.name], False


def export_source(job: _Job) -> tuple[list[str], bool]:
    """The source for other codes in one file."""
    data, size = job.run.source.to_bytes(), job.folder.size_of(job.name)
    if not job.options.force and size is not None:
        with job.folder.reading(job.name) as file:
            if size != len(data) or file.read(size) != data:
                raise ForeignOutputError(_foreign(job.folder.path / job.name))
        return [job.name], True
    job.folder.write(job.name, data)
    return [job.name], False


def export_envmap(job: _Job) -> tuple[list[str], bool]:
    """A map and its meaning: a file of any ending and one beside it, or two in a folder."""
    from aomc_sky.outputs import envmap

    source, folder, bands = job.run.source, job.folder, job.bands
    name, axes_name = (job.name, f"{job.name}.json") if job.name else (envmap.MAP, envmap.AXES)
    axes = envmap.axes_text(source, bands, name)
    head, size = envmap.map_file(source, bands, name)
    with contextlib.nullcontext() if job.name else folder.held(source.plan, force=job.options.force, n_bytes=size):
        if not job.options.force:
            if folder.holds(name, head, size) and folder.holds(axes_name, axes, len(axes)):
                return [name, axes_name], True
            for path in (folder.path / one for one in (name, axes_name) if job.name):
                if os.path.lexists(path):
                    raise ForeignOutputError(_foreign(path))
        prepare_target(folder.path / axes_name)
        folder.require_space(size)
        with appearing(folder.path / name) as file:
            file.write(head)
            for k, part in enumerate(envmap.map_bytes(source, bands, name)):
                file.write(part)
                if job.progress is not None:
                    job.progress(k + 1, envmap.n_parts(name, len(bands)))
        folder.write(axes_name, axes)
    return [name, axes_name], False


def export_aomc(job: _Job) -> tuple[list[str], bool]:
    """A folder that the AOMC program runs."""
    from aomc_sky.outputs.aomc.skydist import aomc_sky, check_scene, water_note, write_aomc_folder

    source = job.run.source
    amc_inp = None if job.options.scene is None else Path(os.path.abspath(job.options.scene))
    if amc_inp is not None:
        amc_inp = amc_inp / "amc.inp" if amc_inp.is_dir() else amc_inp
        if not amc_inp.is_file():
            raise SceneError(f"{job.options.scene}: there is no amc.inp here")
        check_scene(amc_inp, source.plan.wavelength_nm)
        if amc_inp.parent.resolve() == job.folder.path.resolve():
            raise UsageError(f"{job.folder.path} holds the scene itself", "choose another --out")
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
