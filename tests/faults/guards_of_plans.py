"""Guards of rows 46 and 49: what a plan is asked before anything is made from it, and a folder that was sealed anew."""

from __future__ import annotations

from tests.support.guards import Guard

FILE = "source/plan/file.py"
SCHEMA = "source/plan/schema.py"
LAWS = "source/plan/laws.py"

FROM_PLAN = "test_plan_faults.py::test_no_source_is_made_of_a_changed_plan[row-46-crafted-plans-from-plan]"
BY_COMMANDS = "test_plan_faults.py::test_every_command_refuses_a_changed_plan[row-46-crafted-plans-by-every-command]"
AT_RANDOM = (
    "test_plan_faults.py::test_a_plan_with_another_value_gives_good_photons_or_none[row-46-plans-changed-at-random]"
)


def _file(name: str) -> str:
    return f"test_plan_faults.py::test_a_file_that_is_no_plan[row-46-{name}]"


def _without(file: str, text: str, test: str, without: str = "") -> Guard:
    return Guard(row=46, file=file, text=text, without=without, test=test)


PLAN_GUARDS = (
    Guard(
        row=46,
        file=FILE,
        text="        return open_regular(path)\n",
        without='        return open(path, "rb")\n',
        test=_file("a-pipe"),
        hangs=True,
    ),
    _without(FILE, "if name[1] in members:", _file("a-member-twice"), "if False:"),
    _without(
        FILE,
        '            raise not_a_plan(path, f"holds a member',
        _file("a-member-'a/law.npy'"),
        '            continue\n            raise not_a_plan(path, f"holds a member',
    ),
    _without("source/photon_source.py", "        plan.check()\n", FROM_PLAN),
    _without("source/plan/plan.py", "        plan.check(path)\n", BY_COMMANDS),
    _without("cli/commands/info.py", "    _check_plan(path, manifest)\n", BY_COMMANDS),
    _without(SCHEMA, "        _check_names(arrays, options)\n", FROM_PLAN),
    _without(SCHEMA, "        _check_ranges(arrays)\n", FROM_PLAN),
    _without(SCHEMA, "        _check_cells(arrays, options)\n", FROM_PLAN),
    _without(SCHEMA, "        _check_rows(arrays)\n", FROM_PLAN),
    _without(SCHEMA, "        _check_counts(arrays, options, lengths)\n", FROM_PLAN),
    _without(LAWS, "            _check_cells_of_grid(cells, grid, law, k)\n", AT_RANDOM, "            pass\n"),
    _without(LAWS, '            _check_frame(arrays[f"shared_{k}"], f"shared_{k}", law)\n', FROM_PLAN),
    _without(LAWS, '            _check_envelope(arrays[f"bounds_{k}"], f"bounds_{k}")\n', FROM_PLAN),
    _without(LAWS, "    if np.any(mu > bound * (1.0 + 1e-9)):\n", FROM_PLAN, "    if False:\n"),
    _without(LAWS, "    if not holds.all():\n        k = int", FROM_PLAN, "    if False:\n        k = int"),
)

FORGED = "test_forged_runs.py"
_RESEALED = f"{FORGED}::test_verify_sees_what_the_plan_betrays[row-49-resealed-folders]"
_CANNOT_KNOW = "test_what_a_plan_cannot_know_is_named_and_the_scene_betrays_it"
_BY_SCENE = f"{FORGED}::{_CANNOT_KNOW}[row-49-what-only-the-scene-betrays]"

FORGED_GUARDS = (
    Guard(
        row=49,
        file="verify/stored/run.py",
        text="    rebuilt += [counts_check(part) for part in parts if not part.shard.is_named]\n",
        without="",
        test=_RESEALED,
    ),
    Guard(
        row=49,
        file="verify/stored/run.py",
        text="    rebuilt = [*(manifest_check(part, sums) for part in parts)]\n",
        without="    rebuilt: list[Check] = []\n",
        test=_RESEALED,
    ),
    Guard(
        row=49,
        file="verify/stored/run.py",
        text="secrets.randbits(64) if options.block_seed is None else options.block_seed",
        without="options.block_seed or 0",
        test=f"{FORGED}::test_the_blocks_are_drawn_and_told[row-49-blocks-drawn-at-random]",
    ),
    Guard(
        row=49,
        file="verify/stored/run.py",
        text="    unvouched = (*WITHOUT_SCENE, OF_THE_MACHINE)\n",
        without="    unvouched: tuple[str, ...] = ()\n",
        test=_BY_SCENE,
    ),
    Guard(
        row=49,
        file="verify/stored/manifest.py",
        text="        checks.append(_scene_manifest_check(manifest, scene))\n",
        without="        pass\n",
        test=_BY_SCENE,
    ),
    Guard(
        row=49,
        file="verify/stored/manifest.py",
        text="    checks = [_plan_check(plan, scene_plan(plan, scene))]\n",
        without="    checks: list[Check] = []\n",
        test=f"{FORGED}::test_a_run_of_a_plan_that_no_scene_gives[row-49-a-plan-of-no-scene]",
    ),
    Guard(
        row=49,
        file="verify/stored/manifest.py",
        text="    if len(set(formats)) != len(formats):\n",
        without="    if False:\n",
        test=_RESEALED,
    ),
)
