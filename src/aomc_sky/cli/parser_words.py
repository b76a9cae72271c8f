"""The words of a parser as data: sub-commands, options, and the values that they take."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

_PATHS = ("FILE", "PATH", "DIR", "AMC_INP", "RUN", "MODEL")
"""Metavars that stand for files or folders."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Argument:
    """An option or a positional argument.

    Parameters
    ----------
    name : str
        Metavar for a person.
    flags : tuple of str
        ``("-q", "--quiet")``; empty for a positional argument.
    help : str
        One line.
    choices : tuple of str
        Values, if there are but these.
    n_values : int
        Values that it takes. [0 or more]
    takes_many : bool
        As many values as are given.
    is_repeatable : bool
        May stand several times.
    """

    name: str
    flags: tuple[str, ...]
    help: str
    choices: tuple[str, ...]
    n_values: int
    takes_many: bool
    is_repeatable: bool

    @property
    def takes_value(self) -> bool:
        """Whether a value follows."""
        return self.n_values > 0

    @property
    def is_path(self) -> bool:
        """Whether its value is a file or a folder."""
        return self.name in _PATHS


@dataclass(frozen=True, kw_only=True, slots=True)
class Command:
    """A sub-command with its arguments; the program itself has the name ""."""

    name: str
    help: str
    options: tuple[Argument, ...]
    positionals: tuple[Argument, ...]


def commands_of(parser: argparse.ArgumentParser) -> list[Command]:
    """The program and its sub-commands, in the order of the help.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        The parser of all sub-commands.

    Returns
    -------
    list of Command
        The program first.
    """
    commands = [_command("", "", parser)]
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {choice.dest: choice.help or "" for choice in action._choices_actions}
            commands += [_command(name, helps.get(name, ""), sub) for name, sub in action.choices.items()]
    return commands


def _command(name: str, text: str, parser: argparse.ArgumentParser) -> Command:
    arguments = [
        _argument(action)
        for action in parser._actions
        if action.help is not argparse.SUPPRESS and not isinstance(action, argparse._SubParsersAction)
    ]
    return Command(
        name=name,
        help=text,
        options=tuple(a for a in arguments if a.flags),
        positionals=tuple(a for a in arguments if not a.flags),
    )


def _argument(action: argparse.Action) -> Argument:
    metavar = action.metavar if action.metavar is not None else action.dest.upper()
    takes_many = action.nargs in ("+", "*")
    if takes_many and isinstance(metavar, tuple):  # the first value's words, and those of each other one
        metavar = metavar[0]
    choices = tuple(map(str, action.choices or ()))
    if not choices and isinstance(metavar, str) and "|" in metavar:
        choices = tuple(metavar.split("|"))
    n_values = 1 if action.nargs is None else action.nargs if isinstance(action.nargs, int) else 1
    return Argument(
        name=metavar if isinstance(metavar, str) else " ".join(metavar),
        flags=tuple(action.option_strings),
        help=" ".join((action.help or "").replace("%%", "%").split()),
        choices=choices,
        n_values=n_values,
        takes_many=takes_many,
        is_repeatable=type(action).__name__ == "_AppendAction",
    )
