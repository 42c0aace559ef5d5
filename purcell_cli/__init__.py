"""Motion planning for the 3D generalized Purcell swimmer at low Reynolds number.

The names below are the library: ``from purcell_cli import Configuration, Swimmer, plan``.
They are loaded when first used, so that the command line starts quickly. Not by `lazy_loader`: every import would
need it, for the twelve lines at the end of this module.
"""

import sys

if sys.argv[:1] == ["-m"] and {"purcell_cli", "-mpurcell_cli"} & {*sys.orig_argv} and not sys.flags.safe_path:
    del sys.path[0]  # the working folder, where strangers' files may have the names of modules

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from purcell_cli.errors import PurcellError
    from purcell_cli.files.builtin import stored_gaits, stored_scenarios
    from purcell_cli.files.configuration_file import load_configuration, load_goal
    from purcell_cli.files.gait_file import load_gait
    from purcell_cli.files.plan_file import load_plan, write_plan
    from purcell_cli.files.scenario_file import load_scenario
    from purcell_cli.files.swimmer_file import load_swimmer
    from purcell_cli.files.trajectory_csv import write_csv
    from purcell_cli.files.trajectory_reader import read_csv
    from purcell_cli.gaits.pure_stroke import realise
    from purcell_cli.lie_brackets.controllability import controllability
    from purcell_cli.lie_brackets.curvature import curvature
    from purcell_cli.mechanics.configuration import Configuration
    from purcell_cli.mechanics.lift import flow, flow_of_rates
    from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian, flow_and_jacobian_of_moves
    from purcell_cli.mechanics.moves import MoveSequence
    from purcell_cli.mechanics.primitives import PrimitiveSequence
    from purcell_cli.mechanics.swimmer import Swimmer
    from purcell_cli.motion.options import Controls, Effort, Objective, PlanOptions
    from purcell_cli.motion.workspace import Workspace
    from purcell_cli.solution import plan
    from purcell_cli.verification.certificate import certify

__version__ = "0.2.0"

_HOMES = {
    "Configuration": "mechanics.configuration",
    "Controls": "motion.options",
    "Effort": "motion.options",
    "MoveSequence": "mechanics.moves",
    "Objective": "motion.options",
    "PlanOptions": "motion.options",
    "PrimitiveSequence": "mechanics.primitives",
    "PurcellError": "errors",
    "Swimmer": "mechanics.swimmer",
    "Workspace": "motion.workspace",
    "certify": "verification.certificate",
    "controllability": "lie_brackets.controllability",
    "curvature": "lie_brackets.curvature",
    "flow": "mechanics.lift",
    "flow_and_jacobian": "mechanics.lift_derivatives",
    "flow_and_jacobian_of_moves": "mechanics.lift_derivatives",
    "flow_of_rates": "mechanics.lift",
    "load_configuration": "files.configuration_file",
    "load_gait": "files.gait_file",
    "load_goal": "files.configuration_file",
    "load_plan": "files.plan_file",
    "load_scenario": "files.scenario_file",
    "load_swimmer": "files.swimmer_file",
    "plan": "solution",
    "read_csv": "files.trajectory_reader",
    "realise": "gaits.pure_stroke",
    "stored_gaits": "files.builtin",
    "stored_scenarios": "files.builtin",
    "write_csv": "files.trajectory_csv",
    "write_plan": "files.plan_file",
}

__all__ = [
    "Configuration",
    "Controls",
    "Effort",
    "MoveSequence",
    "Objective",
    "PlanOptions",
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
