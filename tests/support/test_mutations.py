"""What a mutation changes: one node, and nothing beside it."""

import ast
import random

import pytest

from tests.support.mutate import PACKAGE, numerical_files
from tests.support.mutations import mutations

ALL = {
    "x = a < b": {"x = a <= b", "x = a >= b"},
    "x = a <= b < c": {"x = a < b < c", "x = a <= b <= c", "x = a <= b >= c"},
    "x = a or b": {"x = a and b", "x = a", "x = b"},
    "x = not a": {"x = a"},
    "x = a - b": {"x = a + b", "x = a", "x = b"},
    "x += a": {"x -= a"},
    "x = (a *\n  b)": {"x = a / b", "x = a", "x = b"},
    "x = 2.0": {"x = 2.02"},
    "x = [0, 0.0, True]": {"x = [1, 0.0, True]", "x = [0, 1.0, True]", "x = [0, 0.0, False]"},
    "x = np.minimum(a, b)": {"x = np.maximum(a, b)"},
    "x = a if b else c": {"x = c if b else a"},
    "if a == b:\n    x = 'ü', c": {"if a != b:\n    x = ('ü', c)"},
    "x: int | None = f'{a + b}'": set(),
    "raise Error(1)": set(),
    "zip(a, b, strict=True)": set(),
}  # fmt: skip


@pytest.mark.parametrize("text", ALL)
def test_all_mutations_of_a_line(text):
    assert {ast.unparse(ast.parse(m.applied(text))) for m in mutations("", text)} == ALL[text]


def test_a_mutant_differs_in_one_place_and_no_line_moves():
    rng = random.Random(1)
    for name in rng.sample(list(numerical_files()), 10):
        text = (PACKAGE / name).read_text()
        found = list(mutations(name, text))
        for m in rng.sample(found, min(4, len(found))):
            mutant = m.applied(text)
            kept, changed = text.split("\n"), mutant.split("\n")
            assert len(kept) == len(changed)
            assert [kept[: m.line - 1], kept[m.end_line :]] == [changed[: m.line - 1], changed[m.end_line :]]
            assert ast.dump(ast.parse(text)) != ast.dump(ast.parse(mutant))


def test_numerical_files_calculate_and_neither_show_nor_write():
    files = set(numerical_files())
    assert {"grid.py", "plan/allocation.py", "kernels/phase/rayleigh.py", "formats/aomc/scanner.py"} <= files
    assert not {name for name in files if name.startswith(("cli/", "engine/", "outputs/", "pictures/"))}
