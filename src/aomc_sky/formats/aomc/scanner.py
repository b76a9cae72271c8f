"""One scanner for both ways in which Fortran reads: fixed columns, and list-directed values.

`fixed_value` gives what gfortran's edit descriptors Iw and Fw.d make of a field; `ListScanner` follows list-directed
input, and every token of it knows its line and column.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import takewhile

from aomc_sky.errors import Span
from aomc_sky.formats.report import Report
from aomc_sky.options import SURE_NM, in_nm

_INTEGER = re.compile(r"[+-]?\d+\Z")
_REAL = re.compile(r"([+-]?)(\d*)(\.?)(\d*)(?:[eEdDqQ]([+-]?\d+)|([+-]\d+))?\Z")
_PIECE = re.compile(r"[^ \t\r,;/]+|[,;/]")
_BLANKS = re.compile(r"[ \t\r;]+")
_INNER_COMMA = re.compile(r"(?<=\d),(?=\d)")
_OF_NUMBERS = "+-.*0123456789"  #: the empty text is in it, too
_EXPONENT = r"(?:[eEdDqQ][+-]?\d+)?"
_MORE_DIGITS = re.compile(rf",\d[\d,]*(?:\.\d*)?{_EXPONENT}")
_THOUSANDS = re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:,\d{{3}})+(?:\.\d*)?{_EXPONENT}\Z")
_NON_FINITE = re.compile(r"[+-]?(?:inf(?:inity)?|nan(?:\([^)]*\))?)\Z", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Token(Span):
    """A value in a line; a null value, and one that is absent, has an empty word and width 1."""

    word: str = ""

    @property
    def behind(self) -> Span:
        """The place where a further value would begin."""
        return Span(self.line, self.column + len(self.word), self.text)


def fixed_value(field: str, decimals: int | None) -> int | float | None:
    """Value of a field under Fw.d, or under Iw where `decimals` is None; None where gfortran refuses it.

    Blanks are ignored, a comma ends the field, and nothing is 0.
    """
    return _fixed_integer(field) if decimals is None else _fixed_real(field, decimals)


def _fixed_integer(field: str) -> int | None:
    before_comma = field.split(",", 1)[0]
    digits = before_comma.replace(" ", "")
    if digits == "" or (digits in {"+", "-"} and before_comma.endswith(" ")):
        return 0  # gfortran takes a sign before a blank as 0, and refuses a sign that ends the field
    return int(digits) if _INTEGER.match(digits) and digits.isascii() else None


def _fixed_real(field: str, decimals: int) -> float | None:
    """Without a point the last d digits are decimals."""
    before_comma = field.split(",", 1)[0]
    text = before_comma.replace(" ", "")
    if text == "":
        return 0.0
    if text[-1] in "+-" and before_comma.endswith(" "):
        text += "0"  # an exponent of blanks
    if _NON_FINITE.match(text):
        return float(text.split("(")[0])
    parts = _REAL.match(text)
    if parts is None or not text.isascii():  # a lone sign, point or exponent is zero to gfortran
        return None
    exponent = _bounded(parts[5] or parts[6] or "0") - (0 if parts[3] else decimals)
    if abs(exponent) > 9999:
        return None
    return float(f"{parts[1]}{parts[2] or '0'}.{parts[4] or '0'}e{exponent}")


def _bounded(exponent: str) -> int:
    """An exponent of any number of digits, beyond 99 999 as this."""
    size = min(99_999, int(exponent.lstrip("+-").lstrip("0")[:6] or 0))
    return -size if exponent.startswith("-") else size


def list_integer(text: str) -> int | None:
    """Value of a list-directed integer, or None if the text is not one."""
    return int(text) if _INTEGER.match(text) and text.isascii() and len(text) < 40 else None


def list_real(text: str) -> float | None:
    """Value of a list-directed real: point optional, exponent by E, D, Q or a sign. Other text gives None."""
    if _NON_FINITE.match(text):
        return float(text.split("(")[0])
    parts = _REAL.match(text)
    if parts is None or not text.isascii() or not (parts[2] or parts[4]):
        return None
    exponent = _bounded(parts[5] or parts[6] or "0")
    return float(f"{parts[1]}{parts[2] or '0'}.{parts[4] or '0'}e{exponent}")


def is_thousands(word: str) -> bool:
    """Whether the commas of a word may part its thousands."""
    return _THOUSANDS.match(word) is not None


def no_number(word: str, *, is_short: bool) -> tuple[str, str]:
    """Message and advice for a word that is no number, in a row that may be too short because two columns touch."""
    advice = "write a blank between two numbers" if is_short and "*" not in word else "write a number"
    if not word.isascii():
        advice = "write plain digits, blanks and signs (ASCII)"
    return f"'{word}' is not a number", advice


def values_of(
    columns: list[str], words: list[str], decimals: list[int | None]
) -> list[tuple[int | float | None, int | float | None]]:
    """What Fortran reads in the columns of each line, and what a person reads in its word."""
    return [
        (fixed_value(text, d), list_integer(word) if d is None else list_real(word))
        for text, word, d in zip(columns, words, decimals, strict=True)
    ]


@dataclass(frozen=True, slots=True)
class Record:
    """The values of one list-directed READ."""

    #: The values in order; a null value is empty. Shorter than asked for where the record ended early.
    tokens: tuple[Token, ...]
    next_line: int  #: Index of the line after the record. [0-based]
    ended_by_slash: bool  #: A slash ended the record and left values unset
    rest: str  #: The text after the last value in its line
    #: How many numbers follow the last value in its line, up to the first other word.
    n_more: int = field(init=False)
    #: Whether the line begins with a word that is meant as no number, such as the sign of a comment.
    is_text: bool = field(init=False)
    has_comma: bool = field(init=False)  #: Whether the line of the last value has a comma

    def __post_init__(self) -> None:
        words, tokens = self.rest.replace(",", " ").replace(";", " ").split(), self.tokens
        n_more = len(list(takewhile(lambda word: list_real(word) is not None, words))) if words else 0
        is_word = bool(tokens) and tokens[0].word[:1] not in _OF_NUMBERS
        is_text = is_word and (len(tokens) == 1 or any(list_real(token.word) is None for token in tokens[1:]))
        object.__setattr__(self, "n_more", n_more)
        object.__setattr__(self, "is_text", is_text)
        object.__setattr__(self, "has_comma", bool(tokens) and "," in tokens[-1].text)

    @property
    def first_word(self) -> Token | None:
        """The first value that is not a number, as where two columns touch or are full of asterisks."""
        return next((token for token in self.tokens if token.word and list_real(token.word) is None), None)

    @property
    def behind(self) -> Span:
        """The place of the first word after the last value."""
        text = self.tokens[-1].text
        return Span(self.tokens[-1].line, len(text) - len(self.rest.lstrip(" \t,;")) + 1, text)

    def reals(self) -> list[float | None]:
        """The values as reals. A null value, and a word that is not a number, give None."""
        return [list_real(token.word) for token in self.tokens]

    def integers(self) -> list[int | None]:
        """The values as whole numbers. Everything else gives None."""
        return [list_integer(token.word) for token in self.tokens]

    def decimal_comma(self, *, at_end: bool = True) -> tuple[int, Span, str, str] | None:
        """Index, span, message and advice for a value with a comma inside, in a record that has all its values.

        A person reads one number in two cases. Either the line has as many words as the record has values, and each is
        a number once its comma is a point. Or, `at_end`, the digits of the last value go on after a comma, and all of
        them are one number. Further columns behind commas, as in ``400,0,1,0.5,0.9``, are not.
        """
        n, last = len(self.tokens), self.tokens[-1]
        words = _BLANKS.split(last.text.strip(" \t\r;"))[:n]
        index = next((k for k, word in enumerate(words) if "," in word), n)
        if index < len(words) == n and all(list_real(_INNER_COMMA.sub(".", word)) is not None for word in words):
            word = words[index]
        elif at_end and "." not in last.word and (more := _MORE_DIGITS.match(self.rest)):
            index, word = n - 1, last.word + more[0].rstrip(",")
        else:
            return None
        decimal, whole = word.replace(",", ".", 1), word.replace(",", "")
        meant = [decimal] * (list_real(decimal) is not None) + [whole] * is_thousands(word)
        if not meant:
            return None
        token = self.tokens[index]
        what = "a decimal comma" if meant[0] == decimal else "a comma between its digits"
        message = f"'{word}' has {what}; Fortran reads {token.word}"
        return index, token.part(0, len(word)), message, f"write {', or '.join(meant)}"


class ListScanner:
    """List-directed records of a file, line by line."""

    def __init__(self, lines: list[str]) -> None:
        self.lines = lines

    def absent(self, line: int) -> Token:
        """The value that is missing where a line begins. [1-based; a file without lines has an empty one]"""
        return Token(line, 1, self.lines[line - 1] if self.lines else "")

    def skip_blank(self, index: int) -> int:
        """Index of the first line from `index` on that is not blank."""
        while index < len(self.lines) and not self.lines[index].strip(" \t\r"):
            index += 1
        return index

    def record(self, index: int, n: int, *, over_many_lines: bool = False) -> Record:
        """Read n values from line `index` on.

        A record goes on in the next line only if that line holds exactly the missing values. With `over_many_lines` the
        line may hold fewer. A short row therefore does not swallow its neighbour.
        """
        tokens: list[Token] = []
        index = self.skip_blank(index)
        while index < len(self.lines):
            missing = n - len(tokens)
            if not tokens:
                values, slash, rest = self._values(index, missing)
            else:  # one value more than is missing is enough to see that the line is another record
                values, slash, rest = self._values(index, missing + 1)
                fits = len(values) <= missing if over_many_lines else len(values) == missing
                if not fits and not slash:
                    return Record(tuple(tokens), index, False, "")
            tokens += values[:missing]
            index += 1
            if slash or len(tokens) >= n:
                return Record(tuple(tokens), index, slash and len(tokens) < n, rest)
            index = self.skip_blank(index)
        return Record(tuple(tokens), index, False, "")

    def _values(self, index: int, limit: int) -> tuple[list[Token], bool, str]:
        """Up to `limit` values of one line, whether a slash ended it, and the rest of the line."""
        text = self.lines[index]
        values: list[Token] = []
        end = 0
        for token, after in _pieces(text, index + 1):
            if token.word == "/":
                return values, True, text[after:]
            repeat, star, value = token.word.partition("*")
            if star and repeat.isdigit() and repeat.isascii() and int(repeat[:9]) > 0:
                times = min(int(repeat[:9]), limit - len(values))
                column = token.column + len(repeat) + 1 if value else token.column
                values += [_token(text, token.line, column, value)] * times
            else:
                values.append(token)
            end = after
            if len(values) >= limit:
                break
        return values[:limit], False, text[end:]


def _token(text: str, line: int, column: int, word: str) -> Token:
    return Token(line, column, text, max(len(word), 1), word)


def _pieces(text: str, line: int) -> Iterator[tuple[Token, int]]:
    """Values and slashes of a line with the position after each; a null value between separators is empty."""
    after_separator = True  # a separator at the start of a line means a null value
    for piece in _PIECE.finditer(text):
        word, start = piece[0], piece.start()
        if word == "/":
            yield _token(text, line, start + 1, "/"), start + 1
            return
        if word in ",;":
            if after_separator:
                yield _token(text, line, start + 1, ""), start
            after_separator = True
        else:
            after_separator = False
            yield _token(text, line, start + 1, word), piece.end()


def ask_unit(wavelengths: Sequence[tuple[Token, float]], code: str, report: Report) -> None:
    """Report wavelengths that are all in another unit, such as 0.44 and 0.55, or 4400 and 5500.

    0, 0.5, 1 to 30 are labels that people give their wavebands.
    """
    if all(value > SURE_NM for _, value in wavelengths):
        lenient = "with --lenient it is nm"
        questions = [
            f"wavelengths are in nm, got {t.word} (angstroms?); write {v / 10:g}; {lenient}" for t, v in wavelengths
        ]
    elif any(value % 1 for _, value in wavelengths):
        questions = [in_nm(value, token.word) for token, value in wavelengths]
    else:
        return
    if all(questions):
        for (token, _), question in zip(wavelengths, questions, strict=True):
            message, _, advice = question.partition("; ")
            report.at(token, code, message, name="wavelength", advice=advice, can_downgrade=True)
