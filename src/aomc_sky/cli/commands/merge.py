"""``aomc-sky merge``: the shards of a run become the run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.commands.run import band_table

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser
    from aomc_sky.engine.merge import MergeResult

_EPILOG = """\
examples:
  aomc-sky merge out                                  all shards stand in out; the run is written beside them
  aomc-sky merge out --remove-shards                  and their own files are removed when it stands
  aomc-sky merge node1/out node2/out --out whole      shards from several folders
"""


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Join the shards that `aomc-sky run --shard k/K` wrote into the files of one run. All "
        "must exist, belong to one plan, and none twice; every block of photons is compared with its hash."
    )
    parser.epilog = _EPILOG
    parser.add_argument("runs", metavar="RUN", nargs="+", help="folder with shards; repeatable")
    parser.add_argument("--out", metavar="DIR", help="folder of the whole run (default: RUN, where there is one only)")
    parser.add_argument(
        "--remove-shards", action="store_true", help="remove the files of the shards when everything else is written"
    )
    cli_options.add_shared(parser, "threads json quiet")
    parser.set_defaults(handler=merge)


def merge(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.cli.progress import progress_bar
    from aomc_sky.engine.merge import merge_shards
    from aomc_sky.outputs.folder.target_file import check_folder

    if arguments.out is not None:
        check_folder(arguments.out, "--out")
    with progress_bar(enabled=cli_options.speaks(arguments)) as progress:
        result = merge_shards(
            [Path(run) for run in arguments.runs],
            None if arguments.out is None else Path(arguments.out),
            remove_shards=arguments.remove_shards,
            threads=arguments.threads or 0,
            progress=progress,
        )
    more = {"folder": str(result.folder), "was_finished": result.was_finished, "removed": result.removed}
    cli_options.answer(arguments, lambda: result.manifest | more, lambda: merge_text(result))
    return 0


def merge_text(result: MergeResult) -> str:
    """What a merge prints when it is done."""
    launched = sum(band.launched for band in result.bands)
    lines = [band_table(result.bands), ""]
    if "shards" not in result.manifest["run"]:
        lines.insert(0, "this run was made in one go: there is nothing to join, and it stays as it is\n")
    elif result.was_finished:
        lines.append("this run was joined before and is complete; nothing was done again")
    else:
        shards = f"{result.n_shards} shard{'s' if result.n_shards > 1 else ''}"
        lines.append(f"{launched} photons of {shards} joined in {result.seconds:.2f} s, every block checked")
    if result.removed:
        lines.append(f"{result.removed} files of shards removed")
    content = result.manifest["content"]["root"][:16]
    lines.append(f"plan {result.manifest['plan_sha256'][:16]}, content {content}, folder {result.folder}")
    return "\n".join(lines)
