"""Tables of options and of keys of sky.toml in Markdown, made from the table of options."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

from aomc_sky.cli import options as cli_options
from aomc_sky.cli.usage import COMMANDS
from aomc_sky.options import OPTIONS, Kind, Option


def keys_table(rows: Mapping[str, Option]) -> str:
    """Keys of sky.toml in Markdown: what each is, its range or words, its option."""
    lines = ["| key | meaning | range | option |", "| --- | --- | --- | --- |"]
    for name, row in rows.items():
        key, text = f"`{name}`", row.text
        if name == "coefficients":
            key, text = "`a` to `e`", f"{name} {text}"
        words = ("true", "false") if row.kind is Kind.SWITCH else [f'"{word}"' for word in row.words]
        values = ", ".join(f"`{word}`" for word in words) or row.range
        unit, option = f" [{row.unit}]" if row.unit else "", "" if row.option == "-" else f"`{row.flag}`"
        lines.append(f"| {key} | {_escaped(text)}{unit} | {values} | {option} |")
    return "\n".join(lines)


def _escaped(text: str) -> str:
    return text.replace("--", r"\--").replace("|", r"\|").replace("[", r"\[")


def groups_of(name: str) -> tuple[dict[str, str], list[str]]:
    """The groups of options that `{options} NAME` shows, and the commands that have them."""
    own = {command: import_module(f"aomc_sky.cli.commands.{command}").GROUPS for command in COMMANDS}
    if name not in own:
        groups = getattr(cli_options, name)
        return groups, [command for command, has in own.items() if set(groups) <= set(has)]
    shared = (cli_options.READING, cli_options.WHEN, cli_options.DRAWN, cli_options.MOON)
    return {title: names for title, names in own[name].items() if all(title not in one for one in shared)}, [name]


def options_table(name: str) -> str:
    """Options of some groups in Markdown."""
    groups, commands = groups_of(name)
    lines = [f"Options of {', '.join(f'`{command}`' for command in commands)}."] if name not in commands else []
    for title, names in groups.items():
        lines += ["", f"**{title[:1].upper()}{title[1:]}**"] if title else []
        lines += ["", "| option | meaning |", "| --- | --- |"]
        for row in (OPTIONS[one] for one in names.split()):
            value = "|".join(cli_options.words_of(row)) or row.value
            shown = f"`{row.flag} {value}`".replace(" `", "`").replace("|", r"\|")
            if row.kind is Kind.SWITCH:
                shown += f", `--no-{row.flag[2:]}`"
            if row.text:
                lines.append(f"| {f'`{row.short}`, ' * (len(row.short) == 2)}{shown} | {_escaped(row.meaning)} |")
    return "\n".join(lines)
