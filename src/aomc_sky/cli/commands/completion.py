"""``aomc-sky completion``: completion scripts for shells, made from the parser."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser

_PATHS = ("FILE", "PATH", "DIR", "AMC_INP", "RUN", "MODEL")
"""Metavars that stand for files or folders."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Argument:
    """An option or a positional argument."""

    name: str  #: metavar for a person
    flags: tuple[str, ...]  #: ``("-q", "--quiet")``; empty for a positional argument
    help: str  #: one line
    choices: tuple[str, ...]  #: values, if there are but these
    n_values: int
    takes_many: bool  #: as many values as are given
    is_repeatable: bool  #: may stand several times

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
    """The program, first, and its sub-commands, in the order of the help."""
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
        choices = tuple(word for word in metavar.split("|") if not word.isupper())  # NAME stands for many
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


_EPILOG = """\
examples:
  aomc-sky completion bash > ~/.local/share/bash-completion/completions/aomc-sky
  aomc-sky completion zsh > "${fpath[1]}/_aomc-sky"
  aomc-sky completion fish > ~/.config/fish/completions/aomc-sky.fish
  source <(aomc-sky completion bash)                  for this shell alone
"""


def add_options(parser: Parser) -> None:
    """What the sub-command takes."""
    parser.description = (
        "Print a completion script for a shell. The script is static: completing a word starts no Python."
    )
    parser.epilog = _EPILOG
    parser.add_argument("shell", choices=tuple(_SCRIPTS), help="the shell")
    parser.set_defaults(handler=completion)


def completion(arguments: argparse.Namespace) -> int:
    """Carry the sub-command out."""
    from aomc_sky.cli.main import build_parser

    print(_SCRIPTS[arguments.shell](commands_of(build_parser(is_complete=True))), end="")
    return 0


def _bash(commands: list[Command]) -> str:
    """Options and values by `compgen`; where nothing is proposed, bash completes file names."""
    names = " ".join(command.name for command in commands[1:])
    top = " ".join(flag for option in commands[0].options for flag in option.flags)
    values, many, options, free = [], [], [], []
    for command in commands[1:]:
        for option in (o for o in command.options if o.takes_value):
            pattern = "|".join(f"{command.name}:{flag}" for flag in option.flags)
            line = f'        {pattern}) words="{" ".join(option.choices)}" ;;'
            many += [line] if option.choices and option.takes_many else []
            values += [line] if option.choices else []
            free += [] if option.choices else [pattern]
        flags = " ".join(flag for option in command.options for flag in option.flags)
        positional = " ".join(choice for argument in command.positionals for choice in argument.choices)
        options.append(f'        {command.name}) flags="{flags}"; words="{positional}" ;;')
    values.append(f"        {'|'.join(free)}) ;;")
    return _BASH.format(
        names=names, top=top, values="\n".join(values), many="\n".join(many), options="\n".join(options)
    )


_BASH = """\
# bash completion of aomc-sky, made by `aomc-sky completion bash`
_aomc_sky() {{
    local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command=${{COMP_WORDS[1]}}
    local words="" flags="" option="" k
    COMPREPLY=()
    if ((COMP_CWORD == 1)); then
        COMPREPLY=($(compgen -W "{names} {top}" -- "$cur"))
        return
    fi
    # bash takes --to=npy for three words
    if [[ $cur == "=" ]]; then
        cur=""
    elif [[ $prev == "=" ]]; then
        prev=${{COMP_WORDS[COMP_CWORD-2]}}
    fi
    case "$command:$prev" in
{values}
        *) option="none" ;;
    esac
    if [[ -z $option ]]; then
        COMPREPLY=($(compgen -W "$words" -- "$cur"))
        return
    fi
    case "$command" in
{options}
    esac
    if [[ $cur == -* ]]; then
        COMPREPLY=($(compgen -W "$flags" -- "$cur"))
        return
    fi
    # options that take several values go on until the next option
    for ((k = COMP_CWORD - 1; k > 1; k--)); do
        [[ ${{COMP_WORDS[k]}} == -* ]] && break
    done
    case "$command:${{COMP_WORDS[k]}}" in
{many}
    esac
    COMPREPLY=($(compgen -W "$words" -- "$cur"))
}}
complete -o default -F _aomc_sky aomc-sky
"""


def _zsh_quoted(text: str) -> str:
    for character in "\\[]:":
        text = text.replace(character, f"\\{character}")
    return text.replace("'", "'\\''")


def _zsh_value(argument: Argument) -> str:
    """Message and action of the values of an option or of an argument; many values go on until the next option."""
    action = f"({' '.join(argument.choices)})" if argument.choices else "_files" if argument.is_path else " "
    many = "*-*:" if argument.takes_many and argument.flags else ""
    return f":{many}{_zsh_quoted(argument.name)}:{action}"


def _zsh_flag(option: Argument, flag: str) -> str:
    """A flag as zsh wants it: with = where a value may follow as --to=npy."""
    return f"{flag}=" if flag.startswith("--") and option.n_values == 1 and not option.takes_many else flag


def _zsh_option(option: Argument) -> str:
    tail = f"'[{_zsh_quoted(option.help)}]{_zsh_value(option) * option.n_values}'"
    flags = [_zsh_flag(option, flag) for flag in option.flags]
    if len(flags) == 1:
        star = "*" if option.is_repeatable else ""
        return f"'{star}{flags[0]}'{tail}"
    return f"'({' '.join(option.flags)})'{{{','.join(flags)}}}{tail}"


def _zsh(commands: list[Command]) -> str:
    described = "\n".join(f"            '{c.name}:{_zsh_quoted(c.help)}'" for c in commands[1:])
    cases = []
    for command in commands[1:]:
        specs = [_zsh_option(option) for option in command.options]
        specs += [f"'{'*' if p.takes_many else ''}{_zsh_value(p)}'" for p in command.positionals]
        listed = " \\\n                ".join(specs)
        cases.append(f"        {command.name})\n            _arguments \\\n                {listed}\n            ;;")
    top = " ".join(_zsh_option(option) for option in commands[0].options)
    return _ZSH.format(described=described, cases="\n".join(cases), top=top)


_ZSH = """\
#compdef aomc-sky
# zsh completion of aomc-sky, made by `aomc-sky completion zsh`
_aomc_sky() {{
    local curcontext="$curcontext" state line
    typeset -A opt_args
    _arguments -C {top} '1:command:->command' '*::argument:->argument'
    case $state in
    command)
        local -a commands=(
{described}
        )
        _describe command commands
        ;;
    argument)
        case $words[1] in
{cases}
        esac
        ;;
    esac
}}
if [[ $funcstack[1] == _aomc* ]]; then
    _aomc_sky "$@"
else
    compdef _aomc_sky aomc-sky
fi
"""


def _fish_quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace("'", "\\'")
    return f"'{escaped}'"


def _fish_option(option: Argument, condition: str) -> str:
    words = ["complete -c aomc-sky", f"-n {condition}"]
    words += [f"-l {f[2:]}" if f.startswith("--") else f"-s {f[1:]}" for f in option.flags]
    if option.choices:
        words.append(f"-x -a {_fish_quoted(' '.join(option.choices))}")
    elif option.takes_value:
        words.append("-r -F" if option.is_path else "-x")
    return " ".join([*words, f"-d {_fish_quoted(option.help)}"])


def _fish(commands: list[Command]) -> str:
    lines = ["# fish completion of aomc-sky, made by `aomc-sky completion fish`", "complete -c aomc-sky -f"]
    lines += [_fish_option(option, "__fish_use_subcommand") for option in commands[0].options]
    for command in commands[1:]:
        lines.append(f"complete -c aomc-sky -n __fish_use_subcommand -a {command.name} -d {_fish_quoted(command.help)}")
    for command in commands[1:]:
        condition = f"'__fish_seen_subcommand_from {command.name}'"
        lines += [_fish_option(option, condition) for option in command.options]
        for positional in command.positionals:
            what = f"-a {_fish_quoted(' '.join(positional.choices))}" if positional.choices else "-F"
            lines.append(f"complete -c aomc-sky -n {condition} {what}")
    return "\n".join([*lines, ""])


_SCRIPTS: dict[str, Callable[[list[Command]], str]] = {"bash": _bash, "zsh": _zsh, "fish": _fish}
"""Shell -> what makes its script."""
