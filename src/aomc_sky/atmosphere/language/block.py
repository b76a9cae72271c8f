"""A checked code block as a function of many altitudes or cosines, and the evaluator that runs it over all at once.

Each lane (one altitude, one cosine) follows its own branches, by masks. A lane that a statement does not concern keeps
its values, and nothing that is worked out in it counts: a division by zero in a branch that is not taken is no error.
The number of steps is limited, and so is their depth (by the parser), hence the time and the memory of a hostile block.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from aomc_sky.atmosphere.language import nodes
from aomc_sky.atmosphere.language.expressions import Scope, Variable
from aomc_sky.atmosphere.language.lexer import Problems, RefusalError
from aomc_sky.atmosphere.language.nodes import Function, Sequence, Type
from aomc_sky.atmosphere.language.statements import read_body
from aomc_sky.errors import SourceText

# lanes that are worked out together: bounds the memory of MAX_VARIABLES vectors, and stays in the cache
_LANES = 4096


@dataclass(frozen=True, kw_only=True, slots=True)
class Block:
    """A checked code block; calling it evaluates it. Pure: equal arguments give equal bits."""

    source: SourceText  #: the block as it stands in its file
    subject: str  #: what it gives, for messages: ``number density of "ozone"``
    gives: Type
    argument: Variable  #: what it is a function of
    unit: str  #: of the argument, for messages; may be empty
    given: tuple[Variable, ...]  #: names that have values from outside
    body: Sequence
    n_slots: int  #: number of its variables

    def __call__(self, argument: np.ndarray, given: Mapping[str, np.ndarray | float]) -> np.ndarray:
        """Values at altitudes or cosines (n,): shape (n,), or (n_component, n) where the block gives a vector.

        They are not looked at: they may be infinite or NaN. An InputFileError where the block has no defined value at
        one of the arguments, or takes too many steps. Accuracy: IEEE float64 for ``+ - * /`` and sqrt, in the order
        written; about 1 ulp for other functions.
        """
        return np.concatenate([self._run(part, given).result for part in _parts(argument)], axis=-1)

    def trace(self, argument: np.ndarray, given: Mapping[str, np.ndarray | float]) -> np.ndarray:
        """A number (n,) uint64 for the way that each argument takes through the block.

        Where two neighbours have equal numbers, they take the same branch of every condition and of every function
        with a bend (``abs``, ``min``, ``floor``): the block is smooth between them. The numbers are hashes; two
        different ways are equal with a probability of 5e-20.
        """
        return np.concatenate([self._run(part, given, traces=True).trace for part in _parts(argument)])

    def _run(self, lanes: np.ndarray, given: Mapping[str, np.ndarray | float], *, traces: bool = False) -> Evaluator:
        def where(lane: int) -> str:
            return f"{self.argument.name} {lanes[lane]:.12g}{' ' if self.unit else ''}{self.unit}"

        run = Evaluator(self.gives, self.n_slots, lanes.size, where, traces=traces)
        run.give(self.argument.slot, lanes)
        for variable in self.given:
            kind = np.int64 if variable.type is Type.INT else np.float64
            run.give(variable.slot, np.asarray(given[variable.name], dtype=kind)[..., None])
        try:
            run.run(self.body)
        except RefusalError as refusal:
            raise self.refused(refusal) from None
        return run

    def refused(self, refusal: RefusalError) -> Exception:
        """Return the error that says a refusal with the place of the block in its file."""
        problems = Problems(self.source, self.subject)
        problems.add(refusal)
        return problems.error()

    def refused_at(self, argument: float | None, message: str, advice: str = "") -> Exception:
        """Return the error for a value that nobody can take, at one argument or (None) as a whole."""
        first = len(self.source.text) - len(self.source.text.lstrip())
        if argument is not None:
            message = f"{message}, {self.argument.name} {argument:.12g} {self.unit}".rstrip()
        return self.refused(RefusalError(first, first + 1, message, advice))


def _parts(argument: np.ndarray) -> list[np.ndarray]:
    # the variables of one part are let go before the next begins
    lanes = np.asarray(argument, dtype=np.float64).ravel()
    return [lanes[start : start + _LANES] for start in range(0, max(lanes.size, 1), _LANES)]


def read_block(
    source: SourceText,
    *,
    subject: str,
    gives: Type,
    argument: str,
    unit: str = "",
    given: Mapping[str, Type] | None = None,
    hints: Mapping[str, str] | None = None,
) -> Block:
    """Read a code block: a body of a GLSL function of one float, of at most 64 KiB.

    `given` are the names that it can read, with their types; `hints` names that it cannot read, with what to do about
    them; `subject` and `unit` stand in messages. An InputFileError has all its problems.

    The text is data from first to last: a lexer and a parser of our own make a tree of it, and nothing that a block
    says is ever handed to Python or to a compiler.
    """
    problems = Problems(source, subject)
    scope = Scope(given or {}, argument, hints or {})
    body = read_body(problems, scope, gives)
    return Block(
        source=source,
        subject=subject,
        gives=gives,
        argument=scope.argument,
        unit=unit,
        given=scope.given,
        body=body,
        n_slots=scope.n_slots,
    )


MAX_STEPS = 20_000

Array = np.ndarray
_HASH = np.uint64(0x9E3779B97F4A7C15)
_STEP = np.uint64(0xD1B54A32D192ED03)
_SHIFT = np.uint64(29)
_KINDS = {Type.BOOL: np.bool_, Type.INT: np.int64}


class Evaluator:
    """The state of one run; `where` says in words which altitude or cosine a lane is, for messages."""

    def __init__(
        self, gives: Type, n_slots: int, n_lanes: int, where: Callable[[int], str], *, traces: bool = False
    ) -> None:
        self._values: list[Any] = [None] * n_slots
        # None: known everywhere; else an array as wide as the value
        self._known: list[Array | None] = [None] * n_slots
        self._n_lanes = n_lanes
        self._where = where
        self._n_steps = 0
        self._loops: list[tuple[Array, Array]] = []
        shape = (gives.n_components, n_lanes) if gives.is_vector else (n_lanes,)
        self.result: Array = np.zeros(shape)
        self.trace: Array | None = np.zeros(n_lanes, dtype=np.uint64) if traces else None

    def give(self, slot: int, value: Array) -> None:
        """Put a value into a variable before the run."""
        self._values[slot] = value

    def run(self, body: nodes.Sequence) -> None:
        """Run the block; `result` holds its value in all lanes."""
        with np.errstate(all="ignore"):
            self._do(body, np.ones(self._n_lanes, dtype=bool))

    def _tick(self, node: Any) -> None:
        self._n_steps += 1
        if self._n_steps > MAX_STEPS:
            message = f"the block takes more than {MAX_STEPS} steps"
            raise RefusalError(node.start, node.start + 1, message, "end the loops earlier, or write less")

    def _fault(self, node: Any, bad: Array, message: str, advice: str = "") -> None:
        if bad.any():
            raise RefusalError(node.start, node.end, f"{message}, {self._where(int(np.argmax(bad)))}", advice)

    # statements: each takes the lanes it concerns and returns those that go on behind it

    def _do(self, node: nodes.Statement, mask: Array) -> Array:
        self._tick(node)
        return _STATEMENTS[type(node)](self, node, mask)

    def _sequence(self, node: nodes.Sequence, mask: Array) -> Array:
        for one in node.statements:
            mask = self._do(one, mask)
            if not mask.any():
                break
        return mask

    def _store(self, node: nodes.Store, mask: Array) -> Array:
        if node.value is None:
            size = node.type.n_components
            shape = (size, 1) if size > 1 else (1,)
            self._values[node.slot] = np.zeros(shape, dtype=_KINDS.get(node.type, np.float64))
            self._known[node.slot] = np.zeros(shape, dtype=bool)
            return mask
        value = self._value(node.value, mask)
        if node.begins:
            self._values[node.slot], self._known[node.slot] = value, None
        elif node.components is None:
            self._put(node.slot, slice(None), value, mask)
        else:
            rows = value if value.ndim > 1 else value[None]
            for component, row in zip(node.components, rows, strict=True):
                self._put(node.slot, component, row, mask)
        return mask

    def _put(self, slot: int, part: int | slice, value: Array, mask: Array) -> None:
        known = self._known[slot]
        if part == slice(None) and mask.all():
            self._values[slot], self._known[slot] = value, None
            return
        # variables may hold one value for all lanes, and share it: copies of full width are written
        old = self._values[slot]
        wide = np.array(np.broadcast_to(old, (*old.shape[:-1], self._n_lanes)))
        wide[part] = np.where(mask, value, wide[part])
        self._values[slot] = wide
        if known is not None:
            wide_known = np.array(np.broadcast_to(known, wide.shape))
            wide_known[part] |= mask
            self._known[slot] = None if wide_known.all() else wide_known

    def _store_at(self, node: nodes.StoreAt, mask: Array) -> Array:
        value, index = self._value(node.value, mask), self._value(node.index, mask)
        self._check_index(node.index, index, node.type.n_components, mask)
        for component in range(node.type.n_components):
            chosen = mask & (index == component)
            if chosen.any():
                self._put(node.slot, component, value, chosen)
        return mask

    def _branch(self, node: nodes.Branch, mask: Array) -> Array:
        on = np.zeros_like(mask)
        for condition, body in node.cases:
            truth = self._value(condition, mask)
            taken = mask & truth
            if taken.any():
                on |= self._do(body, taken)
            mask = mask & ~truth
            if not mask.any():
                return on
        return on | (mask if node.otherwise is None else self._do(node.otherwise, mask))

    def _repeat(self, node: nodes.Repeat, mask: Array) -> Array:
        active = mask if node.first is None else self._do(node.first, mask)
        done = np.zeros_like(mask)
        while True:
            self._tick(node)
            if node.condition is not None:
                truth = self._value(node.condition, active)
                done |= active & ~truth
                active = active & truth
            if not active.any():
                return done
            broken, next_round = np.zeros_like(mask), np.zeros_like(mask)
            self._loops.append((broken, next_round))
            active = self._do(node.body, active) | next_round
            self._loops.pop()
            done |= broken
            if node.step is not None and active.any():
                self._do(node.step, active)

    def _give(self, node: nodes.Give, mask: Array) -> Array:
        value = self._value(node.value, mask)
        np.copyto(self.result, value, where=mask)
        return np.zeros_like(mask)

    def _leave(self, node: nodes.Leave, mask: Array) -> Array:
        broken, next_round = self._loops[-1]
        target = broken if node.ends_loop else next_round
        target |= mask
        return np.zeros_like(mask)

    # expressions: each takes the lanes that count

    def _value(self, node: nodes.Typed, mask: Array) -> Array:
        self._tick(node)
        return _EXPRESSIONS[type(node)](self, node, mask)

    def _constant(self, node: nodes.Constant, mask: Array) -> Array:
        return node.value

    def _read(self, node: nodes.Read, mask: Array) -> Array:
        value, known = self._values[node.slot], self._known[node.slot]
        part: Any = slice(None) if node.components is None else list(node.components)
        if node.components is not None and len(node.components) == 1:
            part = node.components[0]
        if known is not None:
            unknown = ~known[part]
            bad = mask & (unknown.any(axis=0) if unknown.ndim > 1 else unknown)
            self._fault(node, bad, f"{node.name} has no value yet", f"declare it with one: {node.name} = 0.0")
        return value if node.components is None else value[part]

    def _operation(self, node: nodes.Operation, mask: Array) -> Array:
        return self._apply(node, node.function, [self._value(one, mask) for one in node.operands], mask)

    def _apply(self, node: Any, function: Function, values: list[Array], mask: Array) -> Array:
        for is_bad, message in function.faults:
            bad = is_bad(*values)
            if bad.any():
                self._fault(node, mask & (bad.any(axis=0) if bad.ndim > 1 else bad), message)
        if self.trace is not None and function.decides is not None:
            self.trace = self._note(self.trace, function.decides(*values), mask)
        return function.apply(*values)

    def _note(self, trace: Array, decision: Array, mask: Array) -> Array:
        for row in decision if decision.ndim > 1 else decision[None]:
            # a floor beyond the whole numbers of 64 bits has no branches that anybody could resolve
            whole = np.clip(np.nan_to_num(row.astype(np.float64)), -(2.0**62), 2.0**62).astype(np.int64)
            # the sum before the product: no decision leaves a trace as it is
            mixed = ((trace ^ whole.view(np.uint64)) + _STEP) * _HASH
            trace = np.where(mask, mixed ^ (mixed >> _SHIFT), trace)
        return trace

    def _fold(self, node: nodes.Fold, mask: Array) -> Array:
        result = self._value(node.operands[0], mask)
        for function, operand in zip(node.functions, node.operands[1:], strict=True):
            self._tick(node)
            result = self._apply(node, function, [result, self._value(operand, mask)], mask)
        return result

    def _logic(self, node: nodes.Logic, mask: Array) -> Array:
        result = np.full(mask.shape, not node.stops_at)
        open_lanes = mask
        for operand in node.operands:
            truth = self._value(operand, open_lanes)
            result = np.where(open_lanes, truth, result)
            open_lanes = open_lanes & (truth != node.stops_at)
            if not open_lanes.any():
                break
        return result

    def _choose(self, node: nodes.Choose, mask: Array) -> Array:
        result: Array | None = None
        for condition, chosen in node.cases:
            truth = self._value(condition, mask)
            taken = mask & truth
            if taken.any():
                value = self._value(chosen, taken)
                result = value if result is None else np.where(taken, value, result)
            mask = mask & ~truth
        if mask.any() or result is None:
            value = self._value(node.otherwise, mask)
            result = value if result is None else np.where(mask, value, result)
        return result

    def _pick(self, node: nodes.Pick, mask: Array) -> Array:
        value = self._value(node.base, mask)
        return value[node.components[0]] if len(node.components) == 1 else value[list(node.components)]

    def _pick_at(self, node: nodes.PickAt, mask: Array) -> Array:
        value, index = self._value(node.base, mask), self._value(node.index, mask)
        self._check_index(node.index, index, value.shape[0], mask)
        wide, places = np.broadcast_arrays(value, index[None])
        safe = np.clip(places[:1], 0, value.shape[0] - 1)
        return np.take_along_axis(wide, safe, axis=0)[0]

    def _check_index(self, node: nodes.Typed, index: Array, size: int, mask: Array) -> None:
        self._fault(node, mask & ((index < 0) | (index >= size)), f"the index is not between 0 and {size - 1}")


_STATEMENTS: dict[type, Callable[[Evaluator, Any, Array], Array]] = {
    nodes.Store: Evaluator._store,
    nodes.StoreAt: Evaluator._store_at,
    nodes.Sequence: Evaluator._sequence,
    nodes.Branch: Evaluator._branch,
    nodes.Repeat: Evaluator._repeat,
    nodes.Give: Evaluator._give,
    nodes.Leave: Evaluator._leave,
}
_EXPRESSIONS: dict[type, Callable[[Evaluator, Any, Array], Array]] = {
    nodes.Constant: Evaluator._constant,
    nodes.Read: Evaluator._read,
    nodes.Operation: Evaluator._operation,
    nodes.Fold: Evaluator._fold,
    nodes.Logic: Evaluator._logic,
    nodes.Choose: Evaluator._choose,
    nodes.Pick: Evaluator._pick,
    nodes.PickAt: Evaluator._pick_at,
}
