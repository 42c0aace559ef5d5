"""Motion planning for the 3D generalized Purcell swimmer at low Reynolds number.

The names below are the library: ``from purcell_cli import Configuration, Swimmer, plan``.
They are loaded when first used, so that the command line starts quickly.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from purcell_cli.certificate import certify
    from purcell_cli.configuration import Configuration
    from purcell_cli.curvature_form import curvature
    from purcell_cli.documents import load_plan, write_plan
    from purcell_cli.errors import PurcellError
    from purcell_cli.export import read_csv, write_csv
    from purcell_cli.files import load_configuration, load_gait, load_goal, load_scenario, load_swimmer
    from purcell_cli.gaits import realise
    from purcell_cli.lift import flow, flow_and_jacobian, flow_and_jacobian_of_moves, flow_of_rates
    from purcell_cli.local_controllability import controllability
    from purcell_cli.moves import MoveSequence
    from purcell_cli.primitives import PrimitiveSequence
    from purcell_cli.solution import plan
    from purcell_cli.stored import stored_gaits, stored_scenarios
    from purcell_cli.swimmer import Swimmer
    from purcell_cli.workspace import Workspace

__version__ = "0.1.0"

_HOMES = {
    "Configuration": "configuration",
    "MoveSequence": "moves",
    "PrimitiveSequence": "primitives",
    "PurcellError": "errors",
    "Swimmer": "swimmer",
    "Workspace": "workspace",
    "certify": "certificate",
    "controllability": "local_controllability",
    "curvature": "curvature_form",
    "flow": "lift",
    "flow_and_jacobian": "lift",
    "flow_and_jacobian_of_moves": "lift",
    "flow_of_rates": "lift",
    "load_configuration": "files",
    "load_gait": "files",
    "load_goal": "files",
    "load_plan": "documents",
    "load_scenario": "files",
    "load_swimmer": "files",
    "plan": "solution",
    "read_csv": "export",
    "realise": "gaits",
    "stored_gaits": "stored",
    "stored_scenarios": "stored",
    "write_csv": "export",
    "write_plan": "documents",
}

__all__ = [
    "Configuration",
    "MoveSequence",
    "PrimitiveSequence",
    "PurcellError",
    "Swimmer",
    "Workspace",
    "certify",
    "controllability",
    "curvature",
    "flow",
    "flow_and_jacobian",
    "flow_and_jacobian_of_moves",
    "flow_of_rates",
    "load_configuration",
    "load_gait",
    "load_goal",
    "load_plan",
    "load_scenario",
    "load_swimmer",
    "plan",
    "read_csv",
    "realise",
    "stored_gaits",
    "stored_scenarios",
    "write_csv",
    "write_plan",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
