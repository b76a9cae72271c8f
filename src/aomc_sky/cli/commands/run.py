"""``aomc-sky run``: from amc.inp to a run folder."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aomc_sky.cli import options as cli_options
from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.engine.run import JobOptions, JobResult
    from aomc_sky.outputs.blocks.shard import Shard
    from aomc_sky.source.photon_source import PhotonSource
    from aomc_sky.source.scene import Scene

_EPILOG = """\
examples:
  aomc-sky run inputs/clear_day/amc.inp --seed 1 --out out
  aomc-sky run amc.inp --iterations 1e9 --format none        counts and plan only
  aomc-sky run amc.inp --format raw --out - | transport      records of float32 on standard output
  aomc-sky run amc.inp --iterations 1e11 --shard 3/100       one part, on any machine; merge joins them
  aomc-sky run amc.inp --iterations 1e11 --engine dask       by the processes of a Dask cluster
  aomc-sky run amc.inp --dry-run                             what would be modelled, and what not
  aomc-sky run amc.inp --dni 850 --dhi 95 --sun-zenith 32.4  light source 0 under a given weather
"""


def add_parser(commands: Any) -> None:
    """Add the sub-command."""
    parser = commands.add_parser(
        "run",
        help="read amc.inp, sample, write a run folder",
        description="Read amc.inp and the files beside it, share out the photons, emit and write them.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("amc_inp", metavar="AMC_INP", help="amc.inp, or the folder that holds it")
    parser.add_argument(
        "--out", metavar="DIR", help="run folder (default: aomc-sky-out beside amc.inp); - with --format raw"
    )
    parser.add_argument("--seed", type=cli_options.seed, default=0, metavar="INT", help="seed, 0 to 2^64-1 (default 0)")
    cli_options.add_reading_options(parser)
    _add_sampling_options(parser)
    _add_output_options(parser)
    parser.set_defaults(handler=run, resumes=True)


def _sampling_method(word: str) -> str:
    """The word itself; a method that was removed is told with what to write instead."""
    if word not in ("stratified", "iid"):
        from aomc_sky.source.options import refuse_withdrawn

        refuse_withdrawn(word)
    return word


def _add_sampling_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("how photons are drawn (default: the scene's preset)")
    group.add_argument(
        "--allocation",
        choices=("systematic", "largest-remainder", "multinomial", "aomc"),
        help="how integers are shared out (default systematic)",
    )
    group.add_argument(
        "--method",
        type=_sampling_method,
        choices=("stratified", "iid"),
        help="how photons are tied together (default stratified)",
    )
    group.add_argument(
        "--placement", choices=("r2", "philox", "centre"), help="where a photon lies in its cell (default r2)"
    )
    group.add_argument(
        "--order", choices=("shuffled", "patch"), help="order of the photons of a band (default shuffled)"
    )
    group.add_argument(
        "--precision", choices=("float32", "float64"), default="float32", help="of directions (default float32)"
    )
    group.add_argument("--weights", action="store_true", help="carry weights where the launch law is not the flux law")
    group.add_argument(
        "--replicates",
        type=cli_options.whole_number,
        default=1,
        metavar="R",
        help="share the photons of a band among R independent runs, and print standard errors (default 1)",
    )
    cli_options.add_waveband_option(group, "only this band, from 1; repeatable")


def _add_output_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is written and printed")
    group.add_argument(
        "--format",
        choices=("npy", "mcpl", "raw", "none"),
        metavar="npy|mcpl|raw|none",
        action="append",
        help="photon files, repeatable (default npy); none: counts and plan only",
    )
    group.add_argument(
        "--shard", metavar="k/K", help="only part k of K, from 1, in files of its own; `aomc-sky merge` joins them"
    )
    cli_options.add_threads_option(group)
    group.add_argument(
        "--engine", choices=("local", "dask"), default="local", help="who makes the photons (default: this process)"
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of a Dask scheduler, tcp://host:8786 (default: a cluster of processes here)",
    )
    group.add_argument("--dry-run", action="store_true", help="print what would be modelled, write nothing")
    group.add_argument("--force", action="store_true", help="replace another run in the folder")
    cli_options.add_print_options(group)
    group.add_argument("-v", "--verbose", action="store_true", help="print how the files were read")


def run(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    formats = _formats(arguments)
    _check_engine(arguments, formats)
    shard = _shard(arguments, formats)
    scene = cli_options.scene_of(arguments, arguments.amc_inp, wavebands=arguments.waveband)
    if arguments.dry_run:
        from aomc_sky.cli.commands.run_report import dry_run_text, scene_summary

        print(json.dumps(scene_summary(scene)) if arguments.json else dry_run_text(scene))
        return 0
    source = scene.source(
        arguments.seed,
        allocation=arguments.allocation,
        method=arguments.method,
        placement=arguments.placement,
        order=arguments.order,
        precision=arguments.precision,
        weights=arguments.weights,
        replicates=arguments.replicates,
        max_memory_bytes=arguments.max_memory,
    )
    from aomc_sky.engine.run import JobOptions

    options = JobOptions(
        formats=formats,
        threads=arguments.threads or 0,
        force=arguments.force,
        max_memory_bytes=arguments.max_memory,
    )
    if shard is not None:
        _make_shard(arguments, scene, source, options, shard)
        return 0
    result, folder = _carry_out(arguments, scene, source, options)
    _report(arguments, scene, source, result, folder)
    return 0


def _formats(arguments: argparse.Namespace) -> tuple[str, ...]:
    formats = tuple(dict.fromkeys(arguments.format or ("npy",)))
    if "none" in formats and len(formats) > 1:
        raise UsageError("--format none stands alone")
    if arguments.out == "-":
        if formats != ("raw",):
            raise UsageError("--out - needs --format raw, and no other format")
        if arguments.json:
            raise UsageError("--json and --out - both want standard output")
    return formats


def _shard(arguments: argparse.Namespace, formats: tuple[str, ...]) -> Shard | None:
    if arguments.shard is None:
        return None
    from aomc_sky.outputs.blocks.shard import parse_shard

    if arguments.out == "-" or formats != ("npy",):
        raise UsageError("--shard writes npy alone; join the shards with merge and export the run to other formats")
    return parse_shard(arguments.shard)


def _check_engine(arguments: argparse.Namespace, formats: tuple[str, ...]) -> None:
    if arguments.engine == "dask":
        if arguments.shard is not None:
            raise UsageError("--engine dask divides the run by itself; leave --shard out")
        if arguments.out == "-" or formats != ("npy",):
            raise UsageError("--engine dask writes npy alone; export the run to other formats")
    elif arguments.scheduler is not None:
        raise UsageError("--scheduler needs --engine dask")


def _carry_out(
    arguments: argparse.Namespace, scene: Scene, source: PhotonSource, options: JobOptions
) -> tuple[JobResult, Path | None]:
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.run import run_job, stream_job

    with progress_bar(enabled=not (arguments.quiet or arguments.json)) as progress:
        if arguments.out == "-":
            return stream_job(source, scene, sys.stdout.buffer, options, progress), None
        folder = _folder(arguments, scene)
        if arguments.engine == "dask":
            from aomc_sky.engine.cluster.run import run_on_dask

            scheduler = arguments.scheduler
            return run_on_dask(source, scene, folder, options, scheduler=scheduler, progress=progress), folder
        return run_job(source, scene, folder, options, progress), folder


def _folder(arguments: argparse.Namespace, scene: Scene) -> Path:
    of_scene = Path(scene.input_files["amc"]).parent
    if arguments.out is None:
        return of_scene / "aomc-sky-out"
    from aomc_sky.outputs.folder.target_file import check_folder

    check_folder(arguments.out, "--out", scene=of_scene)
    return Path(arguments.out)


def _make_shard(
    arguments: argparse.Namespace, scene: Scene, source: PhotonSource, options: JobOptions, shard: Shard
) -> None:
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.shards.shard import run_shard

    folder = _folder(arguments, scene)
    with progress_bar(enabled=not (arguments.quiet or arguments.json)) as progress:
        result = run_shard(source, scene, folder, options, shard, progress)
    if arguments.json:
        print(json.dumps({**result.manifest, "folder": str(folder), "was_finished": result.was_finished}))
    elif not arguments.quiet:
        from aomc_sky.cli.commands.shard_report import shard_text

        print(shard_text(scene, source, result, folder, verbose=arguments.verbose))


def _report(
    arguments: argparse.Namespace, scene: Scene, source: PhotonSource, result: JobResult, folder: Path | None
) -> None:
    if arguments.json:
        shown = {**(result.manifest or {}), "folder": str(folder), "was_finished": result.was_finished}
        print(json.dumps(shown))
        return
    if arguments.quiet:
        return
    from aomc_sky.cli.commands.run_report import run_text

    stream = sys.stderr if folder is None else sys.stdout
    print(run_text(scene, source, result, folder, verbose=arguments.verbose), file=stream)
