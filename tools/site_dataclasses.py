"""Lets the reference show what the package's frozen dataclasses take, as it does for the standard library's."""

from __future__ import annotations

from typing import Any

import griffe


class FrozenDataclasses(griffe.Extension):
    """Takes `frozen_dataclass` for `dataclasses.dataclass`, which it is to everyone who reads a class."""

    def on_alias_instance(self, *, alias: griffe.Alias, **_: Any) -> None:
        """Look through the name that a module imports."""
        if alias.name == "frozen_dataclass":
            alias.target_path = "dataclasses.dataclass"
