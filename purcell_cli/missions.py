"""Missions planned and carried out: waypoints passed exactly, in the order and the poses that cost least."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from purcell_cli.errors import refuse_types
from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.bead_table import bead_tables
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import home_shape, plane_axis, refuse_displacement
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clock import clock_step
from purcell_cli.motion.coordinates import refuse_large
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.mission import Follow, Mission, Order, Passage, Waypoint
from purcell_cli.motion.options import Controls, PlanOptions
from purcell_cli.motion.plan import Plan, Structure
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planner.missions.curve_legs import CurveLegs
from purcell_cli.planner.missions.leg_price import LegPrice
from purcell_cli.planner.missions.limbs_in_place import in_place, limbs_turned
from purcell_cli.planner.missions.mission_legs import MissionLegs, Stop
from purcell_cli.planner.missions.one_motion import one_motion
from purcell_cli.planner.missions.waypoint_order import cheapest_orders, leg_prices
from purcell_cli.planner.missions.waypoint_poses import Touring
from purcell_cli.planner.progress import Progress, silent
from purcell_cli.planning import plan, planned
from purcell_cli.query import refuse_bent, refuse_query
from purcell_cli.solution import Solution, carried_out
from purcell_cli.wording import counted

_DEARER, _EACH_RAD = 1.4, 25.0
"""A mission may take so many times the price of its legs, and so much more for each [rad], and still fit its clock: up
to then times in it are exact. Short legs take more than their price."""

_ORDERS = {"quick": 1, "standard": 4, "thorough": 12}
"""How many orders of waypoints are planned at most, by effort, where obstacles do not make each plan dear: plans take
some 6 % more or less than orders that are priced alike promise."""
_AS_CHEAP = 1.03
"""Orders that are priced at more than so many times the cheapest are not planned."""


def plan_mission(
    mission: Mission,
    *,
    swimmer: Swimmer | None = None,
    options: PlanOptions = PlanOptions(),
    gaits: Mapping[str, Gait] | None = None,
    progress: Progress = silent,
) -> Solution:
    """Plan a mission, and check it: one motion, whose certificate says that each waypoint is passed, too.

    Args:
        mission: What is to be done.
        swimmer: The swimmer; the paper's where none is given.
        options: What is asked of the plan besides.
        gaits: The stored gaits to plan with; those of the package where none are given.
        progress: Is told how far the search is.

    Raises:
        ParameterError: As for `plan`, and a waypoint that does not keep the limits.
        GaitError: No stored gait for a motion that is needed.
    """
    body = swimmer or Swimmer()
    refuse_types(mission=(mission, Mission), swimmer=(body, Swimmer), options=(options, PlanOptions))
    if mission.plain:
        return plan(mission.start, mission.goal, swimmer=body, options=options, gaits=gaits, progress=progress)
    refuse_query(mission.start, mission.goal, body, options)
    if mission.follow is not None:
        if plane_axis(body) is not None:
            for pose in mission.follow.poses(mission.start):
                refuse_displacement(body, mission.start, Configuration(pose, mission.start.shape), "follow")
        refuse_long(LegPrice(body), [np.eye(4), _ahead(mission.follow.curve.length_m)], body, options)
        return followed(mission, mission.follow, body, options, gaits, progress)
    refuse_waypoints(mission, body, options)
    if body.fluid == "beads":
        bead_tables(body, lambda done, of: progress(done, of, "table of the links' drag, once for this swimmer"))
    touring = Touring(body, LegPrice(body), Limits.of(options))
    dear = options.controls == Controls.SIMULTANEOUS or options.obstacles is not None
    orders = passing_orders(mission, touring, 1 if dear else _ORDERS[options.effort])
    made: list[Plan] = []
    for k, order in enumerate(orders):
        made.append(_in_order(mission, order, touring, options, gaits, _part(progress, k, len(orders), "order")))
    made.sort(key=lambda one: (one.blocked is not None, one.joint_travel_rad))
    every = (carried_out(one, options) for one in made)
    best = next(every)
    return (
        best
        if best.verdict == Verdict.REACHED
        else next((one for one in every if one.verdict == Verdict.REACHED), best)
    )


def _in_order(
    mission: Mission,
    order: Sequence[int],
    touring: Touring,
    options: PlanOptions,
    gaits: Mapping[str, Gait] | None,
    progress: Progress,
) -> Plan:
    """Return a plan that passes a mission's waypoints in an order; arguments as of `plan_mission`."""
    body = touring.swimmer
    chosen = configurations(mission, order, touring)
    for k, one in zip(order, chosen, strict=True):
        if one is not None:
            touring.limits.refuse(body, f"via[{k}]", one)
    poses = [mission.start.pose, *(one.pose for one in chosen if one is not None), mission.goal.pose]
    priced_rad = refuse_long(touring.price, poses, body, options)
    most_rad = _DEARER * priced_rad + _EACH_RAD * (len(order) + 1)
    limits = dataclasses.replace(Limits.of(options), clock_s=clock_step(most_rad / body.joint_rate_rad_s))
    planned_legs = [0]

    def leg(start: Configuration, goal: Configuration, bent: float) -> Plan:
        planned_legs[0] += 1
        part = _part(progress, min(planned_legs[0] - 1, len(order)), len(order) + 1, "leg")
        careful = dataclasses.replace(body, max_bend_rad=bent * body.max_bend_rad)
        return planned(
            start, goal, swimmer=careful, options=options, gaits=gaits, progress=part, clock_s=limits.clock_s
        )

    def in_place(here: Configuration, waypoint: Waypoint) -> Plan | None:
        return turned_in_place(body, here, waypoint, options, limits.clock_s)

    dear = options.controls == Controls.SIMULTANEOUS or options.obstacles is not None
    stops = [Stop(mission.via[k], one) for k, one in zip(order, chosen, strict=True)]
    legs = MissionLegs(body, touring.price, limits, leg, in_place, touring.others, dear).between(
        mission.start, stops, mission.goal
    )
    return joined(body, mission, order, legs)


def turned_in_place(
    swimmer: Swimmer, here: Configuration, waypoint: Waypoint, options: PlanOptions, clock_s: float
) -> Plan | None:
    """Return limbs turned to a waypoint that names them alone, if that keeps the limits."""
    blocks = limbs_turned(swimmer, here.shape, waypoint, clock_s)
    alone = Plan(swimmer, here, waypoint.filled(here), blocks)
    return alone if carried_out(alone, options).limits.kept else None


def followed(
    mission: Mission,
    follow: Follow,
    swimmer: Swimmer,
    options: PlanOptions,
    gaits: Mapping[str, Gait] | None,
    progress: Progress,
) -> Solution:
    """Plan the way along a curve, and check it; arguments as of `plan_mission`.

    Raises:
        ParameterError: As for `plan`, and a tolerance that the swing of the smallest strokes exceeds already.
    """
    found: list[Plan] = []

    def leg(start: Configuration, goal: Configuration, bend_rad: float) -> tuple[Block, ...]:
        body = dataclasses.replace(swimmer, max_bend_rad=bend_rad)
        found.append(planned(start, goal, swimmer=body, options=options, gaits=gaits))
        return found[-1].blocks

    search = CurveLegs(
        swimmer, follow, mission.start, mission.goal, leg, lambda share: progress(round(1000 * share), 1000, "legs")
    )
    blocks = one_motion(swimmer, mission.start, mission.goal, search.legs())
    words = (Structure("legs along a curve", sum(b.joint_travel_rad for b in blocks)),)
    left_out = found[-1].left_out if found else {}
    whole = Plan(swimmer, mission.start, mission.goal, blocks, words, left_out=left_out, follow=follow)
    return carried_out(whole, options)


def refuse_long(price: LegPrice, poses: Sequence[Array], swimmer: Swimmer, options: PlanOptions) -> float:
    """Return about the joint travel of a way along poses of the base [m], each of shape (4, 4) [rad].

    Raises:
        ParameterError: It takes too many rows or too much memory, as far as the price of its legs tells.
    """
    travel_rad = float(np.sum(price(np.array(poses[:-1]), np.array(poses[1:]))))
    if (found := Limits.of(options).too_large(swimmer, 0, travel_rad)) is not None:
        raise found
    return travel_rad


def _ahead(length_m: float) -> Array:
    pose = np.eye(4)
    pose[0, 3] = length_m
    return pose


def refuse_waypoints(mission: Mission, swimmer: Swimmer, options: PlanOptions) -> None:
    """Refuse waypoints at which limits cannot be kept, whatever is chosen for what they leave free.

    Raises:
        ParameterError: Limbs too near each other, a shape that the joints cannot make or links that feel each other do
            not have, or a position out of range.
    """
    limits, home = Limits.of(options), home_shape(swimmer, mission.start.shape)
    for k, one in enumerate(mission.via):
        filled = one.filled(Configuration(mission.start.pose, home))
        refuse_large(swimmer, f"via[{k}]", filled)
        refuse_bent(swimmer, f"via[{k}]", filled)
        refuse_displacement(swimmer, mission.start, filled, f"via[{k}]")
        known = one.position_m is not None and one.orientation is not None
        (limits if known else dataclasses.replace(limits, workspace=None, obstacles=None)).refuse(
            swimmer, f"via[{k}]", filled
        )


def passing_orders(mission: Mission, touring: Touring, most: int) -> list[list[int]]:
    """Return orders in which a mission's waypoints may be passed, as indices into its list, the cheapest first.

    Where the order is free, those that name limbs alone come first: they cost the same anywhere.

    Args:
        mission: The mission.
        touring: The choice of poses.
        most: How many orders, at most.
    """
    every = list(range(len(mission.via)))
    if mission.order == Order.GIVEN or len(every) < 2:
        return [every]
    first = [k for k in every if in_place(mission.via[k])]
    others = [k for k in every if k not in first]
    if len(others) < 2:
        return [first + others]
    prices = leg_prices(touring, mission.start.pose, [mission.via[k] for k in others], mission.goal.pose)
    found = cheapest_orders(*prices, most)
    return [first + [others[k] for k in order] for order, price in found if price <= _AS_CHEAP * found[0][1]]


def configurations(mission: Mission, order: Sequence[int], touring: Touring) -> list[Configuration | None]:
    """Return the configurations at waypoints, what they leave free chosen so that the way is cheap.

    There is none for a waypoint that names limbs alone, where all joints are ball joints: it is passed where they turn.
    """
    via, ball = [mission.via[k] for k in order], touring.swimmer.ball_joints
    home = home_shape(touring.swimmer, mission.start.shape)
    placed = [one for one in via if not (ball and in_place(one))]
    poses = iter(touring.poses(mission.start.pose, placed, mission.goal.pose) if placed else ())
    return [
        None if ball and in_place(one) else one.filled(Configuration(se3.normalised(next(poses)), home)) for one in via
    ]


def joined(swimmer: Swimmer, mission: Mission, order: Sequence[int], legs: Sequence[Plan]) -> Plan:
    """Return the legs of a mission as one plan."""
    blocks: list[Block] = []
    passages = []
    for k, leg in enumerate(legs):
        blocks += leg.blocks
        if k < len(order):
            passages.append(Passage(mission.via[order[k]], order[k], len(blocks)))
    words = f"{counted(len(legs), 'leg')}: " + "; ".join(
        leg.structures[0].words if leg.structures else "strokes go on" if leg.blocks else "nothing to do"
        for leg in legs
    )
    last = legs[-1]
    blocked = [dataclasses.replace(leg.blocked, leg=k) for k, leg in enumerate(legs) if leg.blocked is not None]
    return Plan(
        swimmer,
        mission.start,
        mission.goal,
        tuple(blocks),
        (Structure(words, sum(b.joint_travel_rad for b in blocks)),),
        left_out=last.left_out,
        passages=tuple(passages),
        follow=mission.follow,
        blocked=blocked[0] if blocked else None,
    )


def _part(progress: Progress, k: int, of: int, name: str) -> Progress:
    """Return what is told of the progress of the k-th of some legs or orders; of one alone its parts speak."""

    def tell(done: int, among: int, news: str) -> None:
        whole = max(among, 1)
        words = news if of == 1 else f"{name} {k + 1} of {of}, {news}"
        progress(k * whole + int(np.clip(done, 0, whole)), of * whole, words)

    return tell
