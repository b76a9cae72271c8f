"""The parser: help in two lengths, and usage errors that begin with what is wrong and name what was meant."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NoReturn

from aomc_sky.cli.terminal import painted_help
from aomc_sky.errors import UsageError

_SURE, _LIKELY = 0.75, 0.65
"""Likeness of a word to a known one, from which it is asked whether that was meant."""
_NUMBER = re.compile(r"-\.?\d")


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

    def add_argument(self, action: argparse.Action) -> None:
        """As argparse does it, which forgets how far sub-commands are indented."""
        super().add_argument(action)
        if isinstance(action, argparse._SubParsersAction):
            self._action_max_length += 2


class Parser(argparse.ArgumentParser):
    """A parser of the program or of a sub-command."""

    def __init__(self, **named: Any) -> None:
        super().__init__(formatter_class=_Formatter, exit_on_error=False, **named)
        self.color = False  # Python 3.14 has colours of its own
        self._positionals.title = "arguments"
        self._first: tuple[str, ...] = ()

    def show_first(self, names: str) -> None:
        """Let ``--help`` show these options alone, in this order, and ``--help-all`` all of them in their groups."""
        self._first = tuple(f"--{name}" for name in names.split())
        self.add_argument("--help-all", action=_HelpAll, nargs=0, help="show all options, in groups, and exit")

    # what is shown

    def format_usage(self) -> str:
        """One line, whatever the number of options."""
        words = [self.prog]
        for action in self._actions:
            if action.option_strings and not action.required:
                continue
            words += action.option_strings[:1]
            words += [self._values_text(action)] if action.nargs != 0 else []
        return f"usage: {' '.join(words)} [options]\n"

    def _values_text(self, action: argparse.Action) -> str:
        """The values of an option or an argument, as a person writes them."""
        formatter = self._get_formatter()
        if isinstance(action, argparse._SubParsersAction):
            return str(action.metavar)
        if action.nargs == "+":
            return f"{self._metavar(action)} ..."
        return formatter._format_args(action, self._metavar(action))

    @staticmethod
    def _metavar(action: argparse.Action) -> str:
        if isinstance(action.metavar, tuple):
            return action.metavar[0]
        return action.metavar or ("|".join(map(str, action.choices)) if action.choices else action.dest.upper())

    def format_help(self, *, is_long: bool = False) -> str:
        """The text of ``--help``; `is_long`: with all options."""
        formatter = self._get_formatter()
        formatter.add_text(self.description)
        is_short = bool(self._first) and not is_long
        for title, actions in self._short_sections() if is_short else self._long_sections():
            formatter.start_section(title)
            formatter.add_arguments(actions)
            formatter.end_section()
        formatter.add_text(self._rest() if is_short else None)
        formatter.add_text(self.epilog)
        return painted_help(f"{self.format_usage()}\n{formatter.format_help()}", sys.stdout)

    def _long_sections(self) -> Iterator[tuple[str | None, list[argparse.Action]]]:
        yield from ((group.title, group._group_actions) for group in self._action_groups)

    def _short_sections(self) -> Iterator[tuple[str | None, list[argparse.Action]]]:
        yield self._positionals.title, self._positionals._group_actions
        yield self._optionals.title, self._shown_first()

    def _shown_first(self) -> list[argparse.Action]:
        return [self._option_string_actions[flag] for flag in ("-h", "--help-all", *self._first)]

    def _rest(self) -> str:
        """What is not shown."""
        n_options = sum(bool(action.option_strings) and action.help != argparse.SUPPRESS for action in self._actions)
        heads = [str(group.title) for group in self._action_groups[2:]]
        named = "; ".join(re.split(" [(]|[:,]", head)[0] for head in heads)
        return f"{n_options - len(self._shown_first())} more options with --help-all{named and ': '}{named}."

    def _print_message(self, message: str, file: Any = None) -> None:
        if file is sys.stdout:  # aloud: argparse drops what standard output refuses
            file.write(message)
        else:
            super()._print_message(message, file)

    # what is wrong

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does it, but unknown options are told before anything that is missing."""
        words = sys.argv[1:] if args is None else list(args)
        self._refuse_unknown(words)
        try:
            return super().parse_known_args(words, namespace)
        except argparse.ArgumentError as error:
            raise WrongWordsError(self._said(error)) from None

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does it; words that are left over are named."""
        found, rest = self.parse_known_args(args, namespace)
        if rest:
            raise WrongWordsError(f"{rest[0]!r} is one word too many; a path with blanks stands in quotes")
        return found

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse in our words."""
        raise WrongWordsError(self._said(argparse.ArgumentError(None, message)))

    def _missing(self, name: str) -> str:
        """What to say of the first argument that is missing."""
        if self._commands:
            return f"which command? there are {_listed(self._commands, 'and')}"
        action = next(each for each in self._actions if argparse._get_action_name(each) == name)
        words = (
            f"{action.option_strings[0]} {self._values_text(action)}"
            if action.option_strings
            else self._metavar(action)
        )
        return f"{self._name} needs {words}: {action.help}"

    @property
    def _name(self) -> str:
        """The sub-command; the program itself."""
        return self.prog.rpartition(" ")[2]

    def _refuse_unknown(self, words: Sequence[str]) -> None:
        """Raise for the first word that looks like an option and is none, or the begin of several."""
        for word in words:
            if word == "--" or (not word.startswith("-") and self._commands):
                return
            flag = word.partition("=")[0]
            if len(word) < 2 or word[0] != "-" or " " in word or _NUMBER.match(word) or self._is_known(flag):
                continue
            begun = [known for known in self._option_string_actions if flag[:2] == "--" and known.startswith(flag)]
            if len({self._option_string_actions[known] for known in begun}) > 1:
                raise WrongWordsError(f"{flag} may be {_listed(begun)}; write one of them whole")
            if not begun:
                raise WrongWordsError(self._unknown(flag, words))

    def _is_known(self, flag: str) -> bool:
        """Whether it is an option of ours, or several of one letter."""
        return flag in self._option_string_actions or (flag[1] != "-" and flag[:2] in self._option_string_actions)

    @property
    def _commands(self) -> dict[str, Parser]:
        actions = (action for action in self._actions if isinstance(action, argparse._SubParsersAction))
        return next((dict(action.choices) for action in actions), {})

    def _unknown(self, flag: str, words: Sequence[str]) -> str:
        """What to say of an option: what people mean by it, who has it, or what is like it."""
        from aomc_sky.cli.main import owners_of

        shown = [known for known, action in self._option_string_actions.items() if action.help != argparse.SUPPRESS]
        near = _meant(flag, shown, at_least=_SURE)
        owners = [] if near else owners_of(flag)  # all sub-commands are made for it
        if self._commands and owners:
            command = next((word for word in words if word in owners), owners[0])
            return f"{flag} stands before the command; write aomc-sky {command} ... {flag}"
        none = f"{self._name} has no option {flag}"
        if owners:
            return f"{none}; {_listed(owners, 'and')} {'has' if len(owners) == 1 else 'have'} it"
        near = near or _meant(flag, shown)
        return f"there is no option {flag} before the command{near}" if self._commands else none + near

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        if isinstance(action, argparse._SubParsersAction):
            near = _meant(str(value), action.choices) or f"; there are {_listed(action.choices, 'and')}"
            option = {"help": "; write aomc-sky COMMAND --help", "version": "; write aomc-sky --version"}
            raise WrongWordsError(f"there is no command {value!r}{option.get(value, near)}")
        near = _meant(str(value), map(str, action.choices))
        parts = str(value).split(",")
        if isinstance(action, argparse._AppendAction) and set(parts) <= set(action.choices):
            near = f"; write {' '.join(f'{action.option_strings[0]} {part}' for part in parts)}"
        raise argparse.ArgumentError(action, f"there is no {value!r}{near or '; write ' + _listed(action.choices)}")

    def _said(self, error: argparse.ArgumentError) -> str:
        """An error of argparse in our words."""
        _, is_missing, names = error.message.partition("are required: ")
        if is_missing:
            return self._missing(names.split(", ")[0])
        name = (error.argument_name or "").rpartition("/")[2]
        action = self._option_string_actions.get(name)
        if error.message.startswith("expected ") and error.message.endswith(("argument", "arguments")):
            assert action is not None, "an option"
            n = "a value" if action.nargs is None else f"{action.nargs if action.nargs != '+' else 'some'} values"
            return f"{name} needs {n}: {name} {self._values_text(action)}"
        if error.message.startswith("ignored explicit argument"):
            return f"{name} takes no value"
        _, is_against, other = error.message.partition("not allowed with argument ")
        if is_against:
            return f"{name} cannot stand beside {other}"
        return f"{name}: {error.message}" if name else error.message


def _listed(names: Iterable[object], joint: str = "or") -> str:
    *first, last = map(str, names)
    return f"{', '.join(first)} {joint} {last}" if first else last


def _meant(word: str, known: Iterable[str], *, at_least: float = _LIKELY) -> str:
    """The known word that was meant, as a question; empty where none is near."""
    from aomc_sky.formats.report import nearest, remark_of

    by_name = {name.strip("-").replace("-", "_"): name for name in known if len(name.strip("-")) > 1}
    name = word.strip("-").replace("-", "_")
    best = nearest(name, by_name, at_least=at_least) if by_name else ""
    return f"; did you mean {by_name[best]}{remark_of(name)}?" if best else ""
