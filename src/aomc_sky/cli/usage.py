"""The parser: help in two lengths, and usage errors that begin with what is wrong and name what was meant."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Iterable
from typing import Any, NoReturn

from aomc_sky.errors import UsageError

_LIKELY = 0.65
"""Likeness of a word to a known one, from which it is asked whether that was meant."""


_ELSEWHERE = {
    "diffuse_only": "the sky alone: aomc-sky perez --diffuse-only, or a direct fraction of 0 in difcol.inp",
}
"""Names that another command has, and what to write here."""


class WrongWordsError(UsageError):
    """Words that the parser cannot take."""


class _HelpAll(argparse.Action):
    """Print every option, and leave."""

    def __call__(self, parser: argparse.ArgumentParser, *rest: object, **named: object) -> None:
        assert isinstance(parser, Parser)
        parser._print_message(parser.format_help(is_long=True), sys.stdout)
        parser.exit()


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Sentences are wrapped, examples are not; options have some more columns than argparse gives them."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=28)

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return super()._fill_text(text if "\n" in text else textwrap.fill(text, width), width, indent)


class Parser(argparse.ArgumentParser):
    """A parser of the program or of a sub-command."""

    def __init__(self, **named: Any) -> None:
        super().__init__(formatter_class=_Formatter, **named)
        self.color = False  # Python 3.14 has colours of its own, which the streams of a command would escape
        self._positionals.title = "arguments"
        self._first: tuple[str, ...] = ()

    def show_first(self, names: str) -> None:
        """Let ``--help`` show these options alone, in this order, and ``--help-all`` all of them in their groups."""
        self._first = tuple(f"--{name}" for name in names.split())
        self.add_argument("--help-all", action=_HelpAll, nargs=0, help="show all options, in groups, and exit")

    def format_help(self, *, is_long: bool = False) -> str:
        """The text of ``--help``; `is_long`: with all options."""
        formatter = self._get_formatter()
        needed = [action for action in self._actions if action.required]
        formatter.add_usage(f"{self.prog} {_usage_of(needed)}[options]", [], [])
        formatter.add_text(self.description)
        sections = [(group.title, group._group_actions) for group in self._action_groups]
        rest = None
        if self._first and not is_long:
            shown = [self._option_string_actions[flag] for flag in ("-h", "--help-all", *self._first)]
            sections = [(self._positionals.title, self._positionals._group_actions), (self._optionals.title, shown)]
            n_options = sum(bool(action.option_strings) for action in self._actions)
            rest = f"{n_options - len(shown)} more options with --help-all."
        for title, actions in sections:
            formatter.start_section(title)
            formatter.add_arguments(actions)
            formatter.end_section()
        formatter.add_text(rest)
        formatter.add_text(self.epilog)
        return formatter.format_help()

    def _print_message(self, message: str, file: Any = None) -> None:
        if file is sys.stdout:  # an error of standard output is an error of the command; argparse drops it
            file.write(message)
        else:
            super()._print_message(message, file)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does it; the parser that a word is not for says so."""
        found, rest = super().parse_known_args(args, namespace)
        clock = next((w for w in (getattr(found, "amc_inp", None), *rest) if w and re.match(r"\d\d?:\d\d", w)), None)
        if clock is not None and getattr(found, "time", None):
            self.error(f"--time is one word: write {found.time}T{clock}")
        if rest and rest[0].startswith("-"):
            word, name = rest[0].partition("=")[0], self.prog.rpartition(" ")[2]
            self.error(f"{name} has no option {word}{did_you_mean(word, self._option_string_actions)}")
        if rest:
            self.error(f"{rest[0]!r} is one word too many; a path with blanks stands in quotes")
        return found, rest

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse, with the word that was meant."""
        message = message.removeprefix("argument ")
        choice = re.search(r" \(choose from (.*)\)", message)
        if choice:  # of which Python's versions make different lists
            known = re.findall(r"[\w.+-]+", choice[1])
            near = did_you_mean(message.split("'")[1], known)
            message = message[: choice.start()] + (near or f"; choose from {', '.join(known)}")
        raise WrongWordsError(message)


def _usage_of(needed: Iterable[argparse.Action]) -> str:
    """The arguments and options that a command cannot do without, as a person writes them."""
    words = []
    for action in needed:
        name = action.metavar or "|".join(map(str, action.choices or (action.dest,)))
        words += [*action.option_strings[:1], f"{name}{' ...' if action.nargs == '+' else ''}"]
    return "".join(f"{word} " for word in words)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The known word that was meant, as a question; empty where none is near."""
    from aomc_sky.formats.report import nearest, remark_of

    by_name = {name.strip("-").replace("-", "_"): name for name in known if len(name.strip("-")) > 1}
    name = word.strip("-").replace("-", "_")
    best = nearest(name, by_name, at_least=_LIKELY) if by_name else ""
    if not best:
        return next((f"; {text}" for ours, text in _ELSEWHERE.items() if nearest(name, (ours,), at_least=_LIKELY)), "")
    return f"; did you mean {by_name[best]}{remark_of(name)}?"
