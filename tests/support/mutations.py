"""Mutations of a file of Python: each changes one node of its text.

An operator, a number, a truth, a branch, an operand, or a function that has an opposite. Texts of messages, what is
raised, annotations and decorators have no mutation.
"""

import ast
from collections import defaultdict
from dataclasses import dataclass


def _table(pairs, key=str):
    table = defaultdict(list)
    for one, other in (pair.split() for pair in pairs.split(",")):
        table[key(one)].append(key(other))
    return table


OPERATORS = _table(
    """Lt LtE, LtE Lt, Gt GtE, GtE Gt, Lt GtE, Gt LtE, Eq NotEq, NotEq Eq, Is IsNot, IsNot Is, In NotIn, NotIn In,
    Add Sub, Sub Add, Mult Div, Div Mult, FloorDiv Mult, Mod FloorDiv, Pow Mult, LShift RShift, RShift LShift,
    BitAnd BitOr, BitOr BitAnd, BitXor BitAnd, And Or, Or And""",
    lambda name: getattr(ast, name),
)
FUNCTIONS = _table(
    """min max, max min, minimum maximum, maximum minimum, smaller larger, larger smaller, floor ceil, ceil floor,
    sin cos, cos sin, arcsin arccos, arccos arcsin, any all, all any, argmin argmax, argmax argmin, cumsum cumprod,
    zeros ones, ones zeros, isfinite isnan, sqrt abs, sum max"""
)
_NOT_MUTATED = {"annotation", "returns", "decorator_list", "msg"}
_KEYWORDS = {"strict", "stacklevel"}


@dataclass(frozen=True, kw_only=True)
class Mutation:
    path: str
    line: int
    end_line: int
    start: int  # in bytes of the text
    end: int
    old: str
    new: str

    def applied(self, text):
        """The mutated text, which has as many lines."""
        data = text.encode()
        more = "\n" * data[self.start : self.end].count(b"\n")
        is_statement = isinstance(ast.parse(self.new).body[0], ast.AugAssign)
        new = self.new + more if is_statement else f"({self.new}{more})"
        return (data[: self.start] + new.encode() + data[self.end :]).decode()

    def __str__(self):
        return f"{self.path}:{self.line}: {self.old} -> {self.new}"


def mutations(path, text):
    """All mutations of a file."""
    lines = text.encode().splitlines(keepends=True)
    begin = [sum(map(len, lines[:k])) for k in range(len(lines))]
    for node in _below(ast.parse(text)):
        for new in _instead_of(node):
            start, end = begin[node.lineno - 1] + node.col_offset, begin[node.end_lineno - 1] + node.end_col_offset
            old = " ".join(text.encode()[start:end].decode().split())
            yield Mutation(
                path=path,
                line=node.lineno,
                end_line=node.end_lineno,
                start=start,
                end=end,
                old=old,
                new=ast.unparse(new),
            )


def _below(node):
    for field, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            is_text = isinstance(child, (ast.JoinedStr, ast.Raise, ast.Match))  # and a pattern takes no parentheses
            is_text |= isinstance(child, ast.keyword) and child.arg in _KEYWORDS
            if isinstance(child, ast.AST) and field not in _NOT_MUTATED and not is_text:
                yield child
                yield from _below(child)


def _instead_of(node):
    """Nodes that may stand in place of this one."""

    def but(**changed):
        return type(node)(**(dict(ast.iter_fields(node)) | changed))

    match node:
        case ast.Compare():
            for k, op in enumerate(node.ops):
                yield from (but(ops=[*node.ops[:k], other(), *node.ops[k + 1 :]]) for other in OPERATORS[type(op)])
        case ast.BoolOp():
            yield from (but(op=other()) for other in OPERATORS[type(node.op)])
            yield from node.values
        case ast.BinOp():
            yield from (but(op=other()) for other in OPERATORS[type(node.op)])
            yield from (node.left, node.right)
        case ast.AugAssign():
            yield from (but(op=other()) for other in OPERATORS[type(node.op)])
        case ast.UnaryOp():
            yield node.operand
        case ast.IfExp():
            yield but(body=node.orelse, orelse=node.body)
        case ast.Call(func=ast.Name(id=name)) if name in FUNCTIONS:
            yield from (but(func=ast.Name(id=other)) for other in FUNCTIONS[name])
        case ast.Call(func=ast.Attribute(attr=name)) if name in FUNCTIONS:
            yield from (but(func=ast.Attribute(value=node.func.value, attr=other)) for other in FUNCTIONS[name])
        case ast.Constant(value=bool() as value):
            yield ast.Constant(value=not value)
        case ast.Constant(value=int() as value):
            yield ast.Constant(value=value + 1)
        case ast.Constant(value=float() as value):
            yield ast.Constant(value=1.01 * value if value else 1.0)
