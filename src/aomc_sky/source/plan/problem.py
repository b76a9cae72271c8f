"""How a rule of the schema of plans says what is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np

from aomc_sky.errors import InputFileError, Problem

Arrays = Mapping[str, np.ndarray]

_MOST_SHOWN = 100


class PlanRuleError(Exception):
    """Code, member, and what is wrong with it; `naming` adds the path."""

    def __init__(self, code: str, member: str, message: str) -> None:
        self.code, self.member, self.message = code, member, message
        super().__init__(code, member, message)


def refuse_value(member: str, found: object, expected: str) -> PlanRuleError:
    """The problem of values that a plan cannot have (E954)."""
    text = found if isinstance(found, str) else shown(found)
    return PlanRuleError("E954", member, f"found {text}, wanted {expected}")


def shown(value: object) -> str:
    """A value for a message: short, and without characters that a terminal obeys."""
    text = ascii(value.item() if isinstance(value, np.generic) else value)
    return text if len(text) <= _MOST_SHOWN else f"{text[: _MOST_SHOWN - 3]}..."


@contextmanager
def naming(path: str) -> Iterator[None]:
    """Turn the problem of a rule into the error of a file, with code, path and member."""
    try:
        yield
    except PlanRuleError as rule:
        problem = Problem(
            path=path,
            line=0,
            column=0,
            code=rule.code,
            field=rule.member,
            message=rule.message,
            advice="make the run again, or take the plan.npz that it wrote",
        )
        raise InputFileError([problem]) from None
