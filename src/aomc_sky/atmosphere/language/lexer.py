"""Text of a code block to tokens: names, whole numbers, real numbers and symbols."""

from __future__ import annotations

import enum
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from aomc_sky.atmosphere.language.refusal import Problems, RefusalError

MAX_BLOCK_BYTES = 65536
MAX_INT = 2**31 - 1

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
    """One word of the text.

    Parameters
    ----------
    kind : Kind
        What it is.
    text : str
        As written; empty at the end of the block.
    start, end : int
        Offsets of its first character and behind its last one.
    value : int or float
        Of a number, else 0.
    """

    kind: Kind
    text: str
    start: int
    end: int
    value: int | float = 0


def read_tokens(problems: Problems) -> list[Token]:
    """Return the tokens of the block, the last of kind END.

    Parameters
    ----------
    problems : Problems
        Holds the block, and takes what is wrong with it.

    Raises
    ------
    InputFileError
        The block is too long, or with all that is no token.
    """
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
        raise RefusalError(start, end, "a code block has no lines for a preprocessor", "write a comment after //")
    if match["line"] is not None:
        raise RefusalError(
            start, start + 1, f"{word[0]} has no meaning in a code block", "there are no texts, only numbers"
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
        raise RefusalError(start, end, f"{core[:20]} is too large for a number of double precision")
    if value == 0.0 and any(digit in "123456789" for digit in re.split("[eE]", core)[0]):
        raise RefusalError(start, end, f"{core[:20]} is too small for a number of double precision")
    return Token(kind=Kind.FLOAT, text=core, start=start, end=end, value=value)


def _bad_tail(core: str, tail: str, start: int, end: int) -> RefusalError:
    if core == "0" and tail[0] in "xX":
        return RefusalError(start, end, f"{(core + tail)[:20]} is a hexadecimal number", "write it with ten digits")
    if tail.lower() == "lf":
        return RefusalError(start, end, f"{core}{tail} has type double", "leave out lf: all numbers have 64 bits")
    if tail[0].isalpha() and tail.isidentifier():
        advice = f"write {core}.0" if tail in ("f", "F") else f"write {core}*{tail}, if that is meant"
        return RefusalError(start, end, f"{(core + tail)[:40]} is not a number", advice)
    return RefusalError(start, end, f"{(core + tail)[:40]} is not a number")
