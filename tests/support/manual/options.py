"""The options that single commands have beside those that all stages take, as the command line declares them."""

from __future__ import annotations

from typing import Any

import typer

from robotid.cli.app import app
from support.manual.markdown import table

COMMON = {"out", "set", "axis", "json", "quiet", "force", "dry-run", "jobs", "accept", "debug", "help", "version"}
"""Those that the page lists once for all."""


def own_options() -> str:
    """A table of every command's own options."""
    commands: dict[str, Any] = getattr(typer.main.get_command(app), "commands")  # noqa: B009
    rows = [
        (f"`{name}`", f"`{_spelled(option)}`", _meaning(option))
        for name, command in commands.items()
        for option in command.params
        if option.param_type_name == "option" and not _is_common(option)
    ]
    return table(("command", "option", "meaning"), rows)


def _is_common(option: Any) -> bool:
    return any(name.lstrip("-") in COMMON for name in option.opts)


def _spelled(option: Any) -> str:
    value = "" if option.is_flag else f" {option.metavar or option.name.upper()}"
    return f"{option.opts[0]}{value}"


def _meaning(option: Any) -> str:
    text = (option.help or "").strip().rstrip(".")
    text = f"{text[0].lower()}{text[1:]}" if text[1:2].islower() or text[1:2] == " " else text
    told = not option.is_flag and option.show_default and option.default not in (None, "", [])
    return f"{text}; by default {option.default}" if told else text
