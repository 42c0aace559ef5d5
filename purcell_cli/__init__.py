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
    from purcell_cli.environment.scene import Scene
    from purcell_cli.environment.solids import Box, Capsule, HalfSpace, Sphere
    from purcell_cli.environment.tube import Tube
    from purcell_cli.errors import PurcellError
    from purcell_cli.feedback.fit import Fit, fit
    from purcell_cli.files.builtin import stored_gaits, stored_scenarios
    from purcell_cli.files.configuration_file import load_configuration, load_goal
    from purcell_cli.files.curve_file import load_curve
    from purcell_cli.files.gait_file import load_gait
    from purcell_cli.files.measured_reader import read_measured
    from purcell_cli.files.plan_file import PlanDocument, load_plan, write_plan
    from purcell_cli.files.scenario_file import load_scenario
    from purcell_cli.files.swimmer_file import load_swimmer, write_swimmer
    from purcell_cli.files.trajectory_csv import write_csv
    from purcell_cli.files.trajectory_reader import read_csv
    from purcell_cli.gaits.atlas import atlas
    from purcell_cli.gaits.design import design
    from purcell_cli.gaits.design_problem import DesignTask
    from purcell_cli.gaits.gait import Gait, Stroke
    from purcell_cli.gaits.pure_stroke import realise
    from purcell_cli.lie_brackets.controllability import controllability
    from purcell_cli.lie_brackets.curvature import curvature
    from purcell_cli.mechanics.configuration import Configuration
    from purcell_cli.mechanics.connection import connection, shape_from_angles
    from purcell_cli.mechanics.drag import LinkDrag, LinkDrags, LinkSize, LinkSizes
    from purcell_cli.mechanics.joints import Joint
    from purcell_cli.mechanics.lift import flow, flow_of_rates
    from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian, flow_and_jacobian_of_moves
    from purcell_cli.mechanics.moves import MoveSequence
    from purcell_cli.mechanics.primitives import PrimitiveSequence
    from purcell_cli.mechanics.swimmer import Swimmer
    from purcell_cli.mechanics.wall import Wall
    from purcell_cli.missions import plan_mission
    from purcell_cli.motion.curve import Curve
    from purcell_cli.motion.measured_trajectory import MeasuredTrajectory
    from purcell_cli.motion.mission import Follow, Mission, Order, Waypoint
    from purcell_cli.motion.options import Controls, Effort, Objective, PlanOptions
    from purcell_cli.motion.trajectory import Trajectory
    from purcell_cli.motion.workspace import Workspace
    from purcell_cli.planning import plan
    from purcell_cli.solution import Solution
    from purcell_cli.verification.certificate import Certificate, certify

__version__ = "0.2.0"

_HOMES = {
    "Box": "environment.solids",
    "Capsule": "environment.solids",
    "Certificate": "verification.certificate",
    "Configuration": "mechanics.configuration",
    "Controls": "motion.options",
    "Curve": "motion.curve",
    "DesignTask": "gaits.design_problem",
    "Effort": "motion.options",
    "Fit": "feedback.fit",
    "Follow": "motion.mission",
    "Gait": "gaits.gait",
    "HalfSpace": "environment.solids",
    "Joint": "mechanics.joints",
    "LinkDrag": "mechanics.drag",
    "LinkDrags": "mechanics.drag",
    "LinkSize": "mechanics.drag",
    "LinkSizes": "mechanics.drag",
    "MeasuredTrajectory": "motion.measured_trajectory",
    "Mission": "motion.mission",
    "MoveSequence": "mechanics.moves",
    "Objective": "motion.options",
    "Order": "motion.mission",
    "PlanDocument": "files.plan_file",
    "PlanOptions": "motion.options",
    "PrimitiveSequence": "mechanics.primitives",
    "PurcellError": "errors",
    "Scene": "environment.scene",
    "Solution": "solution",
    "Sphere": "environment.solids",
    "Stroke": "gaits.gait",
    "Swimmer": "mechanics.swimmer",
    "Trajectory": "motion.trajectory",
    "Tube": "environment.tube",
    "Wall": "mechanics.wall",
    "Waypoint": "motion.mission",
    "Workspace": "motion.workspace",
    "atlas": "gaits.atlas",
    "certify": "verification.certificate",
    "connection": "mechanics.connection",
    "controllability": "lie_brackets.controllability",
    "curvature": "lie_brackets.curvature",
    "design": "gaits.design",
    "fit": "feedback.fit",
    "flow": "mechanics.lift",
    "flow_and_jacobian": "mechanics.lift_derivatives",
    "flow_and_jacobian_of_moves": "mechanics.lift_derivatives",
    "flow_of_rates": "mechanics.lift",
    "load_configuration": "files.configuration_file",
    "load_curve": "files.curve_file",
    "load_gait": "files.gait_file",
    "load_goal": "files.configuration_file",
    "load_plan": "files.plan_file",
    "load_scenario": "files.scenario_file",
    "load_swimmer": "files.swimmer_file",
    "plan": "planning",
    "plan_mission": "missions",
    "read_csv": "files.trajectory_reader",
    "read_measured": "files.measured_reader",
    "realise": "gaits.pure_stroke",
    "shape_from_angles": "mechanics.connection",
    "stored_gaits": "files.builtin",
    "stored_scenarios": "files.builtin",
    "write_csv": "files.trajectory_csv",
    "write_plan": "files.plan_file",
    "write_swimmer": "files.swimmer_file",
}

__all__ = [
    "Box",
    "Capsule",
    "Certificate",
    "Configuration",
    "Controls",
    "Curve",
    "DesignTask",
    "Effort",
    "Fit",
    "Follow",
    "Gait",
    "HalfSpace",
    "Joint",
    "LinkDrag",
    "LinkDrags",
    "LinkSize",
    "LinkSizes",
    "MeasuredTrajectory",
    "Mission",
    "MoveSequence",
    "Objective",
    "Order",
    "PlanDocument",
    "PlanOptions",
    "PrimitiveSequence",
    "PurcellError",
    "Scene",
    "Solution",
    "Sphere",
    "Stroke",
    "Swimmer",
    "Trajectory",
    "Tube",
    "Wall",
    "Waypoint",
    "Workspace",
    "atlas",
    "certify",
    "connection",
    "controllability",
    "curvature",
    "design",
    "fit",
    "flow",
    "flow_and_jacobian",
    "flow_and_jacobian_of_moves",
    "flow_of_rates",
    "load_configuration",
    "load_curve",
    "load_gait",
    "load_goal",
    "load_plan",
    "load_scenario",
    "load_swimmer",
    "plan",
    "plan_mission",
    "read_csv",
    "read_measured",
    "realise",
    "shape_from_angles",
    "stored_gaits",
    "stored_scenarios",
    "write_csv",
    "write_plan",
    "write_swimmer",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
