"""What is wrong with a piece of a value, before it is known where in which file the value stands."""

from __future__ import annotations


class BadValueError(Exception):
    """Raised by the parsers of values; the reader of the file adds path, line and column.

    Parameters
    ----------
    code : str
        As in `aomc_sky.errors.Problem`.
    message, advice : str
        What was found and what was allowed; what to write instead.
    offset, width : int
        First offending character of the value and how many to underline; width 0 is the whole value.
    """

    def __init__(self, code: str, message: str, *, advice: str = "", offset: int = 0, width: int = 0) -> None:
        self.code = code
        self.message = message
        self.advice = advice
        self.offset = offset
        self.width = width
        super().__init__(message)


def quoted(text: str) -> str:
    """A piece of a file as a message shows it: in quotes, short, without what would disturb a terminal."""
    shown = text if len(text) <= 40 else f"{text[:37]}..."
    return "'" + "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in shown) + "'"
