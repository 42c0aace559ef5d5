"""What the site holds that no page's file holds: the reference of the commands, made from the command line itself."""

from __future__ import annotations

import re
from typing import Any

COMMANDS = "reference/commands.md"

_HEAD = """\
# Commands

What `purcell --help` and `purcell COMMAND --help` say, taken from the program when this site is built.
[Exit codes](exit-codes.md) are the same for all commands. `purcell --version` prints the version, and
`purcell --install-completion` teaches your shell the commands.
"""


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def _table(name: str, records: list[tuple[str, str]]) -> list[str]:
    if not records:
        return []
    rows = [f"| `{left}` | {_cell(right)} |" for left, right in records]
    return ["", f"| {name} | meaning |", "| --- | --- |", *rows]


def commands_page() -> str:
    """Return the page of all commands: usage, arguments, options with their defaults, and an example."""
    from purcell_cli.cli.app import built

    group = built()
    outer = group.make_context("purcell", [], resilient_parsing=True)
    lines = [_HEAD]
    for name, command in group.commands.items():
        context = command.make_context(name, [], parent=outer, resilient_parsing=True)
        arguments, options = [], []
        for parameter in command.get_params(context):
            left, right = parameter.get_help_record(context)
            if parameter.param_type_name == "argument":
                arguments.append((re.sub(r" <.*>$", "", left), right))
            else:
                options.append((left, right))
        usage = context.get_usage().removeprefix("Usage: ")
        lines += [f"## {name}", "", command.help, "", "```text", usage, "```"]
        lines += [*_table("argument", arguments), *_table("option", options), ""]
        if command.epilog:
            lines += [re.sub(r"\[/?\w*\]", "", command.epilog), ""]
    return "\n".join(lines)


def on_files(files: Any, config: Any) -> Any:
    """Add the page of the commands to the site's files."""
    from mkdocs.structure.files import File

    files.append(File.generated(config, COMMANDS, content=commands_page()))
    return files
