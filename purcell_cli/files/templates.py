"""The files that `purcell init` writes: start, goal, swimmer, servo map, mission, scenario; every key is explained."""

from __future__ import annotations

from purcell_cli.errors import UnknownNameError
from purcell_cli.files.builtin import find_swimmer, stored_swimmers
from purcell_cli.files.servo_map_file import ServoMap
from purcell_cli.mechanics.joint_motion import plane_axis
from purcell_cli.wording import nearest_hint

START = """\
# A start configuration. Every key may be left out; nothing else may stand here.
# An orientation is one of: euler_deg or euler_rad ([psi, theta, phi]: yaw, pitch, roll),
# quaternion_wxyz, or matrix (rows first). The base's is in the world, a limb's in the base.
base:
  position_m: [0.0, 0.0, 0.0]
  orientation: {euler_deg: [0, 0, 0]}
limb1: {euler_deg: [0, 0, 0]}        # at the base's +x end; left out, in line with the base
limb2: {euler_deg: [0, 0, 0]}        # at the base's -x end
"""

GOAL = """\
# A goal: a configuration, as in start.yaml.
base:
  position_m: [0.002, 0.0, 0.0]
  orientation: {euler_deg: [0, 0, 10]}
limb1: {euler_deg: [0, 0, 0]}
limb2: {euler_deg: [0, 0, 0]}
# workspace_m: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}   # a box that all three links stay in
"""

SWIMMER = """\
# A swimmer and its fluid. The values here are those of the paper's swimmer, and what a key has when it is left out.
base_half_length_m: 0.1
limb_half_length_m: 0.1
slenderness: 0.01                    # radius / full length of a link
viscosity_pa_s: 0.95                 # glycerin
drag_ratio: 2.0                      # lateral / longitudinal, by the law cox
max_bend_rad: 1.0                    # how far a gait may bend a limb's axis from the base's axis
joint_rate_rad_s: 1.0
drag: cox                            # cox | cylinder | spheroid, or the whole drag of links in numbers:
# drag:                              # any left out: as cox
#   base:  {along_n_s_per_m: 0.13, across_n_s_per_m: 0.26, turn_n_m_s: 8.6e-4, spin_n_m_s: 9.6e-6}
#   limb1: {across_n_s_per_m: 0.6}
links: {}                            # a link's own size, where it differs:
# links:
#   limb2: {half_length_m: 0.08, slenderness: 0.02}
body_radius_m: 0.0                   # a sphere at the middle of the base that drags too
fluid: local                         # each link alone in the fluid; or beads: links that feel each other's flow
# wall: {point_m: [0, 0, -0.2], normal: [0, 0, 1]}   # with beads: a plane wall; simulate, track --truth know it
# joints:                            # left out, ball joints; else universal, hinge or fixed:
#   limb1: universal                 # yaw (psi) and pitch (theta), no roll
#   limb2: {kind: hinge, axis: yaw, range_deg: [-90, 60], rate_rad_s: 0.5}
# joint_acceleration_rad_s2: 4.0     # left out, rates may jump
"""

SCENARIO = """\
# A scenario: one motion to plan, and what must come of it. Plan it with
#   purcell plan scenario.yaml
# or judge it, together with others, with
#   purcell batch scenario.yaml
name: first                          # letters, digits, '-', '_' and '.'; its results bear it
start: start.yaml                    # a path from this file's folder, or the mapping itself
goal: goal.yaml
swimmer: swimmer.yaml
# via:                               # configurations to pass exactly; a key left out is free there
#   - base: {position_m: [0.001, 0.0, 0.0]}
#   - limb1: {euler_deg: [10, 0, 0]}
# order: given                       # or free: the planner chooses the order of the waypoints
# follow: {path: curve.csv, tolerance_m: 0.07}   # instead: a curve for the base's middle; columns x_m,y_m,z_m
# obstacles:                         # no part of any link may touch one, at any instant
#   - {sphere: {centre_m: [0.5, 0.5, 0.0], radius_m: 0.1}}
#   - {capsule: {from_m: [0.5, -0.5, 0.0], to_m: [0.5, -0.5, 0.5], radius_m: 0.05}}
#   - {box: {centre_m: [-0.6, 0.0, 0.0], size_m: [0.1, 0.5, 0.5], orientation: {euler_deg: [20, 0, 0]}}}
#   - {half_space: {point_m: [0, 0, -0.6], normal: [0, 0, 1]}}   # the swimmer stays where the normal points to
#   - {tube: {centreline: vessel.csv, radius_m: 0.55}}   # it stays inside; columns x_m,y_m,z_m and, if wanted, radius_m
#   - {mesh: {file: part.stl, scale: 0.001}}   # a closed surface; scale makes its coordinates metres
expect:
  verdict: reached                   # or: not reached, not found within limits, error
  position_tolerance: 1.0e-9         # in units of L
  angle_tolerance_rad: 1.0e-9
  # max_joint_travel_rad: 20
  # max_duration_s: 20
  # min_clearance_m: 0.05
  # error: a part of the message     # for an input that must be refused
# A sweep makes one scenario of each combination of values; start, goal and swimmer must then be mappings.
# sweep:
#   swimmer.slenderness: [0.005, 0.01, 0.02]
#   goal.base.position_m[0]: {start: 0.0, stop: 0.01, num: 11}
"""

MISSION = """\
# A mission: a scenario with something to do on the way. Plan it, and look at it, with
#   purcell plan mission.yaml --out mission.csv
#   purcell plot mission.csv --scenario mission.yaml --out mission.png
name: mission
start: {}
swimmer: swimmer.yaml
via:                                 # passed exactly in what each names; the rest is free there, and chosen
  - base: {position_m: [0.1, 0.0, 0.0]}
  - base: {position_m: [0.2, 0.1, 0.0]}
  # - limb1: {euler_deg: [20, 0, 0]}   # a limb alone: it turns where the swimmer is
order: given                         # or free: the planner chooses the order, of up to 12 waypoints
goal: {base: {position_m: [0.3, 0.1, 0.0]}}
obstacles:                           # no part of any link touches one, at any instant; scenario.yaml has all kinds
  - {sphere: {centre_m: [0.1, 0.45, 0.0], radius_m: 0.1}}
# follow: {path: curve.csv, tolerance_m: 0.07}   # instead of via: a curve for the base's middle; columns x_m,y_m,z_m
expect: {verdict: reached}
"""

_SERVOS = """\
# A servo map, for a robot that plays a plan: which hinges a limb's joint is made of, and what their servos are told.
#   purcell export trajectory.csv --to servo --map servos.yaml
# Every key may be left out; nothing else may stand here.
# The hinges' axes from the base outwards: z yaw, y pitch, x roll. A joint with one hinge or two has fewer letters.
hinge_order: {ORDERS}
# How far the middle one of three hinges must stay from +-90 degrees, where the outer two share an axis.
lock_margin_deg: 5.0
# A servo is told zero + sign * scale * angle; the angle is in degrees, and 0 with the limbs in line with the base.
channels:
CHANNELS
# A hobby servo takes pulses: 1500 microseconds in the middle, 1000 more or less for 90 degrees.
# limb1_yaw: {unit: us, zero: 1500.0, sign: -1, scale: 11.111, range: [500.0, 2500.0]}
"""


def _servos(servo_map: ServoMap) -> str:
    """Return a servo map with every key explained."""
    orders = ", ".join(f"limb{chain.limb}: {chain.order}" for chain in servo_map.chains)
    channels = [
        f"  {name}: {{unit: deg, zero: 0.0, sign: 1, scale: 1.0, range: [{channel.low}, {channel.high}]}}"
        for name, channel in servo_map.channels.items()
    ]
    return _SERVOS.replace("ORDERS", orders).replace("CHANNELS", "\n".join(channels))


SERVOS = _servos(ServoMap.of({}, {}))

_PLANAR_GOAL = GOAL.replace("euler_deg: [0, 0, 10]", "euler_deg: [10, 0, 0]", 1)
"""The goal for swimmers whose base stays in its x-y plane."""

FILES = {
    "start.yaml": START,
    "goal.yaml": GOAL,
    "swimmer.yaml": SWIMMER,
    "servos.yaml": SERVOS,
    "mission.yaml": MISSION,
    "scenario.yaml": SCENARIO,
}
"""Each file's text by name."""


def files_for(swimmer: str) -> dict[str, str]:
    """Return each file's text by name, with a stored swimmer in place of the paper's.

    Args:
        swimmer: The stored swimmer's name.

    Raises:
        UnknownNameError: No stored swimmer has it.
    """
    known = stored_swimmers()
    if swimmer not in known:
        hint = nearest_hint(swimmer, known)
        raise UnknownNameError(f"--swimmer: a stored swimmer is wanted ({', '.join(known)}){hint}, found {swimmer!r}")
    text = known[swimmer].read_text(encoding="utf-8")
    own = find_swimmer(str(known[swimmer]))
    goal = GOAL if plane_axis(own) is None else _PLANAR_GOAL
    return {**FILES, "goal.yaml": goal, "swimmer.yaml": text, "servos.yaml": _servos(ServoMap.of_swimmer(own))}
