"""What is wrong with a command's words: the nearest name where one is unknown, and each option by its own name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import typer

from purcell_cli.wording import nearest_hint


def usage_message(error: typer.TyperException, arguments: Sequence[str]) -> str:
    """Return what is wrong with the words of a command, on one line.

    Args:
        error: What typer found.
        arguments: The words.
    """
    named: Any = error  # typer keeps its kinds of errors to itself; they are told apart by what they know
    command: Any = getattr(getattr(named, "ctx", None), "command", None)
    if command is not None and hasattr(named, "possibilities"):
        known = [name for param in command.params for name in (*param.opts, *param.secondary_opts)]
        known = [name for name in known if name.startswith("-")]
        return f"{error.message}{nearest_hint(named.option_name, known)}"
    text = " ".join(error.format_message().split())
    if text.startswith("No such command") and "mean" not in text:
        word = next((a for a in arguments if not a.startswith("-")), "")
        return text + nearest_hint(word, getattr(command, "commands", ()))
    return text


def usage_hint(error: typer.TyperException) -> str:
    """Return how the command is called, and what tells more; nothing where typer does not say of which it is."""
    context: Any = getattr(error, "ctx", None)
    if context is None:
        return ""
    return f"{context.get_usage()}\nTry '{context.command_path} --help' for help.\n"


def with_flag(message: str, command: str, program: Any) -> str:
    """Return a message about a value by the option that gave it: "dt: ..." is "--dt: ..." for who typed that."""
    found = re.match(r"([a-z][a-z_-]*)(?=: (?!wanted))", message)
    known = [name for param in program.commands[command].params for name in param.opts] if command else []
    flag = f"--{found[1].replace('_', '-')}" if found else ""
    return f"{flag}{message[found.end() :]}" if found and flag in known else message
