"""Text of a code block to tokens, and what a block is refused for."""

from __future__ import annotations

import enum
import math
import re
from dataclasses import dataclass, field
from typing import NamedTuple

from aomc_sky.errors import MAX_PROBLEMS_SHOWN, InputFileError, Problem, SourceText

MAX_BLOCK_BYTES = 65536
MAX_NODES = 10_000
MAX_INT = 2**31 - 1


class Span(NamedTuple):
    """Offsets of a piece of the text."""

    start: int
    end: int


class RefusalError(Exception):
    """A problem of the text; the caller knows the file."""

    def __init__(self, span: Span, message: str, advice: str = "") -> None:
        self.span, self.message, self.advice = span, message, advice
        super().__init__(message)


@dataclass(slots=True)
class Problems:
    """The problems of one code block."""

    source: SourceText
    subject: str  #: what the block gives, for messages
    found: list[Problem] = field(default_factory=list)

    def add(self, refusal: RefusalError) -> None:
        """Note a problem; with more than are ever shown, end the reading at once."""
        (start, end), source = refusal.span, self.source
        width = max(1, end - start)
        self.found.append(source.problem(start, "E403", self.subject, refusal.message, refusal.advice, width))
        if len(self.found) > MAX_PROBLEMS_SHOWN:
            self.raise_found()

    def raise_found(self) -> None:
        """Raise all problems together, if there are any."""
        if self.found:
            raise InputFileError(self.found)


class Kind(enum.Enum):
    """Kinds of tokens."""

    NAME = enum.auto()
    NUMBER = enum.auto()
    SYMBOL = enum.auto()
    END = enum.auto()


class Token(NamedTuple):
    """One word of the text."""

    kind: Kind
    text: str  #: as written; empty at the end of the block
    span: Span


_TOKEN = re.compile(
    r"""(?P<space>[ \t\r\n\f\v]+ | //[^\n]* | /\*.*?\*/)
      | (?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?[A-Za-z_0-9.]*)
      | (?P<name>[A-Za-z_][A-Za-z_0-9]*)
      | (?P<comment>/\*.*)
      | (?P<symbol><<=|>>=|\+\+|--|[+\-*/%&|^]=|[<>=!]=|&&|\|\||\^\^|<<|>>|[-+*/%<>=!?:;,.(){}\[\]&|^~])
      | (?P<other>[#"'`\\][^\n]*|.)""",
    re.VERBOSE | re.DOTALL,
)
_BRACKETS = ("(", ")", "{", "}", "[", "]", ",", ";")


def read_tokens(problems: Problems) -> list[Token]:
    """Return the tokens of the block, the last of kind END; raise all other characters together."""
    text = problems.source.text
    size = len(text.encode("utf-8", "surrogatepass"))
    if size > MAX_BLOCK_BYTES:
        message = f"the block has {size} bytes, more than {MAX_BLOCK_BYTES}"
        problems.add(RefusalError(Span(0, 1), message, "write less"))
        problems.raise_found()
    tokens = []
    for match in _TOKEN.finditer(text):
        if match.lastgroup != "space":
            try:
                tokens.append(_token(match))
            except RefusalError as refusal:
                problems.add(refusal)
    nodes = [one for one in tokens if one.text not in _BRACKETS]
    if len(nodes) > MAX_NODES:
        message = f"the block has more than {MAX_NODES} numbers, names and operators"
        problems.add(RefusalError(nodes[MAX_NODES].span, message, "write less"))
    # the parser would only repeat them in other words
    problems.raise_found()
    end = len(text.rstrip())
    return [*tokens, Token(Kind.END, "", Span(end, end))]


def _token(match: re.Match[str]) -> Token:
    span, word = Span(*match.span()), match.group()
    match match.lastgroup:
        case "number":
            number_value(word, span)
            return Token(Kind.NUMBER, word, span)
        case "symbol":
            return Token(Kind.SYMBOL, word, span)
        case "name" if "__" in word or word.startswith("gl_"):
            raise RefusalError(span, f"the name {word[:60]} is reserved in GLSL", "write a name without __ and gl_")
        case "name":
            return Token(Kind.NAME, word, span)
        case "comment":
            raise RefusalError(Span(span.start, span.start + 2), "this comment has no end", "close it with */")
    if word[0] == "#":
        raise RefusalError(span, "a code block has no preprocessor", "write a comment after //")
    message = f"the character {word[0]!a} has no meaning in a code block"
    raise RefusalError(Span(span.start, span.start + 1), message, "write numbers, names and operators")


_INT = re.compile(r"0|[1-9][0-9]*")
_FLOAT = re.compile(r"((?:[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+(?=[eE]))(?:[eE][+-]?[0-9]+)?)[fF]?")


def number_value(word: str, span: Span) -> int | float:
    """Return the value of a number, an int where it has neither point nor exponent."""
    shown, real = word[:40], _FLOAT.fullmatch(word)
    if _INT.fullmatch(word):
        if len(word) > 10 or int(word) > MAX_INT:
            raise RefusalError(span, f"the whole number {shown} is beyond {MAX_INT}", "write a float: 3e9")
        return int(word)
    if real is None:
        advice = "write decimal digits alone, such as 10 or 10.0, or a product such as 10*km"
        raise RefusalError(span, f"{shown} is not a number", advice)
    value = float(real[1])
    if math.isinf(value) or (value == 0.0 and re.match("[0.]*[1-9]", word)):
        size = "large" if value else "small"
        raise RefusalError(span, f"{shown} is too {size} for a double-precision number", "write 1e-300 to 1e300")
    return value
