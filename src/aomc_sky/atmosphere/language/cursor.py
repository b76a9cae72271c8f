"""A place in the tokens of a block, with the questions a parser asks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from aomc_sky.atmosphere.language.lexer import Kind, Token
from aomc_sky.atmosphere.language.refusal import RefusalError
from aomc_sky.atmosphere.language.syntax import MAX_NESTING


class Cursor:
    """Goes through tokens once.

    Parameters
    ----------
    tokens : list of Token
        Of the whole block, the last of kind END.
    """

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
            message = f"brackets and statements lie more than {MAX_NESTING} deep in each other here"
            raise RefusalError(token.start, token.end, message, "give parts of it names of their own")
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
