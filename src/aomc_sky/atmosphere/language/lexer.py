"""Text of a code block to tokens, a way through them, and what a block is refused for."""

from __future__ import annotations

import enum
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from aomc_sky.errors import MAX_PROBLEMS_SHOWN, InputFileError, Problem, SourceText

MAX_BLOCK_BYTES = 65536
MAX_INT = 2**31 - 1
MAX_NESTING = 100

_TOKEN = re.compile(
    r"""(?P<space>[ \t\r\n\f\v]+ | //[^\n]* | /\*.*?\*/)
      | (?P<open>/\*)
      | (?P<number>(?:[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+)(?:[eE][+-]?[0-9]+)?)(?P<tail>[A-Za-z_0-9.]*)
      | (?P<name>[A-Za-z_][A-Za-z_0-9]*)
      | (?P<symbol><<=|>>=|\+\+|--|[+\-*/%&|^]=|[<>=!]=|&&|\|\||\^\^|<<|>>|[-+*/%<>=!?:;,.(){}\[\]&|^~])
      | (?P<line>[#"'`\\][^\n]*)
      | (?P<other>.)""",
    re.VERBOSE | re.DOTALL,
)


class Kind(enum.Enum):
    """What a token is."""

    NAME = enum.auto()
    INT = enum.auto()
    FLOAT = enum.auto()
    SYMBOL = enum.auto()
    END = enum.auto()


@dataclass(frozen=True, kw_only=True, slots=True)
class Token:
    """One word of the text."""

    kind: Kind
    text: str  #: as written; empty at the end of the block
    start: int
    end: int
    value: int | float = 0  #: of a number


def read_tokens(problems: Problems) -> list[Token]:
    """Return the tokens of the block, the last of kind END; raise all that is no token together."""
    text = problems.source.text
    size = len(text.encode("utf-8", "surrogatepass"))
    if size > MAX_BLOCK_BYTES:
        problems.add(RefusalError(0, 1, f"the block has {size} bytes, more than {MAX_BLOCK_BYTES}", "write less"))
        problems.raise_found()
    tokens = list(_tokens(text, problems))
    # a parser would only repeat them in other words
    problems.raise_found()
    return tokens


def _tokens(text: str, problems: Problems) -> Iterator[Token]:
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup
        if kind == "space":
            continue
        try:
            yield _token(match)
        except RefusalError as refusal:
            problems.add(refusal)
        if kind == "open":
            break
    end = len(text.rstrip())
    yield Token(kind=Kind.END, text="", start=end, end=end)


def _token(match: re.Match[str]) -> Token:
    start, end = match.span()
    word = match.group()
    if match["number"] is not None:
        return _number(match["number"], match["tail"], start)
    if match["name"] is not None:
        if "__" in word or word.startswith("gl_"):
            raise RefusalError(start, end, f"the name {word} is reserved in GLSL", "write a name without __ and gl_")
        return Token(kind=Kind.NAME, text=word, start=start, end=end)
    if match["symbol"] is not None:
        return Token(kind=Kind.SYMBOL, text=word, start=start, end=end)
    if match["open"] is not None:
        raise RefusalError(start, end, "this comment has no end", "close it with */")
    if word[0] == "#":
        raise RefusalError(start, end, "a code block has no preprocessor", "write a comment after //")
    if match["line"] is not None:
        raise RefusalError(
            start, start + 1, f"{word[0]} has no meaning in a code block", "a block has numbers only, no text"
        )
    raise RefusalError(start, end, f"the character {word!a} has no meaning in a code block")


def _number(core: str, tail: str, start: int) -> Token:
    end = start + len(core) + len(tail)
    is_float = any(sign in core for sign in ".eE")
    if tail and not (is_float and tail in ("f", "F")):
        raise _bad_tail(core, tail, start, end)
    if not is_float:
        if len(core) > 1 and core[0] == "0":
            raise RefusalError(start, end, f"{core} begins with 0, which GLSL reads as octal", "write it without the 0")
        if len(core) > 10 or int(core) > MAX_INT:
            raise RefusalError(start, end, f"the whole number {core[:20]} is beyond {MAX_INT}", "write a float: 3e9")
        return Token(kind=Kind.INT, text=core, start=start, end=end, value=int(core))
    value = float(core)
    if math.isinf(value):
        raise RefusalError(start, end, f"{core[:20]} is too large for a double-precision number")
    if value == 0.0 and any(digit in "123456789" for digit in re.split("[eE]", core)[0]):
        raise RefusalError(start, end, f"{core[:20]} is too small for a double-precision number")
    return Token(kind=Kind.FLOAT, text=core, start=start, end=end, value=value)


def _bad_tail(core: str, tail: str, start: int, end: int) -> RefusalError:
    if core == "0" and tail[0] in "xX":
        return RefusalError(start, end, f"{(core + tail)[:20]} is a hexadecimal number", "write it with decimal digits")
    if tail.lower() == "lf":
        return RefusalError(start, end, f"{core}{tail} has type double", "leave out lf: all numbers have 64 bits")
    if tail[0].isalpha() and tail.isidentifier():
        advice = f"write {core}.0" if tail in ("f", "F") else f"write {core}*{tail}, if that is meant"
        return RefusalError(start, end, f"{(core + tail)[:40]} is not a number", advice)
    return RefusalError(start, end, f"{(core + tail)[:40]} is not a number")


class Cursor:
    """A place in the tokens of a block, with the questions a parser asks."""

    def __init__(self, tokens: list[Token]) -> None:
        self._tokens = tokens
        self._index = 0
        self._nesting = 0

    @property
    def token(self) -> Token:
        """The token that comes next."""
        return self._tokens[self._index]

    @property
    def behind(self) -> int:
        """Offset behind the last token that was taken."""
        return self._tokens[self._index - 1].end if self._index else 0

    def at(self, *symbols: str) -> bool:
        """Whether one of these symbols or words comes next."""
        return self.token.kind in (Kind.SYMBOL, Kind.NAME) and self.token.text in symbols

    def next_is(self, symbol: str) -> bool:
        """Whether this symbol comes after the next token."""
        return self._index + 1 < len(self._tokens) and self._tokens[self._index + 1].text == symbol

    def take(self) -> Token:
        """Return the next token and go on; the end stays the end."""
        token = self.token
        if token.kind is not Kind.END:
            self._index += 1
        return token

    def take_if(self, *symbols: str) -> Token | None:
        """Take the next token if it is one of these."""
        return self.take() if self.at(*symbols) else None

    def expect(self, symbol: str, where: str) -> Token:
        """Take this symbol, or refuse its absence: behind the last token, where it would be written."""
        if not self.at(symbol):
            raise RefusalError(
                self.behind, self.behind, f"{symbol} is missing {where}; {self._found}", f"write {symbol}"
            )
        return self.take()

    def unexpected(self, message: str, advice: str = "") -> RefusalError:
        """Return a refusal that stands at the next token and says what it is."""
        return RefusalError(self.token.start, self.token.end, f"{message}; {self._found}", advice)

    @property
    def _found(self) -> str:
        return "the block ends" if self.token.kind is Kind.END else f"found {self.token.text[:40]}"

    @contextmanager
    def nested(self) -> Iterator[None]:
        """Guard one level of brackets, braces or statements inside statements."""
        if self._nesting >= MAX_NESTING:
            token = self.token
            message = f"brackets and statements are nested more than {MAX_NESTING} deep here"
            raise RefusalError(token.start, token.end, message, "put parts of it into variables")
        self._nesting += 1
        try:
            yield
        finally:
            self._nesting -= 1

    def skip_statement(self) -> None:
        """Go behind the statement that could not be read: to its ``;``, or behind the braces it opened."""
        n_open = 0
        while self.token.kind is not Kind.END:
            if n_open == 0 and self.at("}"):
                return
            token = self.take()
            n_open += {"{": 1, "}": -1}.get(token.text, 0)
            if n_open == 0 and token.text in (";", "}"):
                return


BLOCK_CODE = "E403"


class RefusalError(Exception):
    """A problem of the text between two offsets; whoever catches it knows the file."""

    def __init__(self, start: int, end: int, message: str, advice: str = "") -> None:
        self.start, self.end, self.message, self.advice = start, end, message, advice
        super().__init__(message)


@dataclass(slots=True)
class Problems:
    """The problems of one code block."""

    source: SourceText
    subject: str  #: what the block gives, for messages
    found: list[Problem] = field(default_factory=list)

    def add(self, refusal: RefusalError) -> None:
        """Note a problem; with more than are ever shown, end the reading at once."""
        width = max(1, refusal.end - refusal.start)
        self.found.append(
            self.source.problem(refusal.start, BLOCK_CODE, self.subject, refusal.message, refusal.advice, width)
        )
        if len(self.found) > MAX_PROBLEMS_SHOWN:
            self.raise_found()

    def raise_found(self) -> None:
        """Raise all problems together, if there are any."""
        if self.found:
            raise self.error()

    def error(self) -> InputFileError:
        """Return the error that says all problems, in the order of the file."""
        return InputFileError(sorted(self.found, key=lambda one: (one.line, one.column)))
