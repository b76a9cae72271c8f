"""Guards of row 46: what a plan is asked before anything is made from it."""

from __future__ import annotations

from tests.support.guards import Guard

FILE = "source/plan_file.py"
SCHEMA = "source/plan_schema.py"
LAWS = "source/plan_laws.py"

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
    _without(FILE, "if name[1] in found:", _file("a-member-twice"), "if False:"),
    _without(
        FILE,
        '            raise not_a_plan(path, f"holds a member',
        _file("a-member-'a/law.npy'"),
        '            continue\n            raise not_a_plan(path, f"holds a member',
    ),
    _without("source/photon_source.py", "        plan.check()\n", FROM_PLAN),
    _without("source/plan.py", "        plan.check(path)\n", BY_COMMANDS),
    _without("cli/info.py", "    _check_plan(path, manifest)\n", BY_COMMANDS),
    _without(SCHEMA, "        _check_names(arrays, options)\n", FROM_PLAN),
    _without(SCHEMA, "        _check_ranges(arrays)\n", FROM_PLAN),
    _without(SCHEMA, "        _check_cells(arrays, options)\n", FROM_PLAN),
    _without(SCHEMA, "        _check_rows(arrays)\n", FROM_PLAN),
    _without(SCHEMA, "        _check_counts(arrays, options, lengths)\n", FROM_PLAN),
    _without(SCHEMA, "            _check_sobol(arrays, options)\n", FROM_PLAN, "            pass\n"),
    _without(LAWS, "            _check_cells_of_grid(cells, grid, law, k)\n", AT_RANDOM, "            pass\n"),
    _without(LAWS, '            _check_frame(arrays[f"shared_{k}"], f"shared_{k}", law)\n', FROM_PLAN),
    _without(LAWS, '            _check_envelope(arrays[f"bounds_{k}"], f"bounds_{k}")\n', FROM_PLAN),
    _without(LAWS, "    if np.any(mu > bound * (1.0 + 1e-9)):\n", FROM_PLAN, "    if False:\n"),
    _without(LAWS, "    if not holds.all():\n        k = int", FROM_PLAN, "    if False:\n        k = int"),
)
