"""Direct multiple shooting with CasADi and IPOPT, from several starts.

States at the ends of all intervals and the controls in them are unknowns; one Runge-Kutta step of order four per
interval ties them together. The integral of the squared controls is minimised: with joint travel itself IPOPT needs
some five times as long. Every start swims random sines, its states by simulation, over one of a few horizons. The
Jacobian is handed to IPOPT in closed form, with which an iteration takes much less time than with
CasADi's own; the Hessian is approximated, since its exact form costs more than it spares.
"""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import casadi as cs
import numpy as np

from benchmarks.peers.judge import Answer
from benchmarks.peers.model import CONTROLS, STATES, Model, quaternion_product, state_of
from benchmarks.peers.queries import Query
from purcell_cli.mechanics.configuration import Deviation

LONG_S = 20.0
"""Horizons above this have intervals of their own [s]."""
ARRIVED = 0.01
"""The simulated error with which a start has arrived (L, rad); the replay judges with more room."""


@dataclasses.dataclass(frozen=True)
class Settings:
    """What a user of multiple shooting would try.

    Attributes:
        intervals_s: How long intervals are: on horizons up to `LONG_S`, and above [s].
        horizons: Parts of the estimated time, one start after the other; each has its share of the cap at most.
    """

    intervals_s: tuple[float, float] = (0.2, 0.4)
    horizons: tuple[float, ...] = (0.5, 1.0, 2.0)


SETTINGS = Settings()


def estimated_time(query: Query) -> float:
    """Return about how long a swim takes with all joints at once [s]: 0.1 L/s along, 2 degrees/s about."""
    off = Deviation.between(query.start, query.goal)
    along = 10.0 * off.position_m / query.swimmer.length_m
    return 4.0 + along + 25.0 * off.base_rad + off.limb1_rad + off.limb2_rad


class Shooting:
    """The program for one query and horizon.

    Args:
        query: The query.
        model: Its swimmer.
        count: How many intervals there are.
        interval_s: How long each is [s].
        cap_s: The processor time that IPOPT has [s].
    """

    def __init__(self, query: Query, model: Model, count: int, interval_s: float, cap_s: float) -> None:
        self.first, self.last = (state_of(c, query.swimmer.length_m) for c in (query.start, query.goal))
        self.count, self.interval_s, self.one = count, interval_s, model.step(1)
        x, u = cs.MX.sym("x", STATES, count), cs.MX.sym("u", CONTROLS, count)
        before, h = cs.horzcat(cs.DM(self.first), x[:, :-1]), cs.DM.ones(1, count) * interval_s
        gaps = self.one.map(count)(before, u, h) - x
        arrival = self._arrival()
        off, by_last = arrival(x[:, -1])
        slopes = cs.horzsplit(model.step_slope().map(count)(before, u, h), STATES + CONTROLS)
        states = cs.diagcat(*[s[:, :STATES] for s in slopes[1:]])
        corner = cs.MX(STATES, STATES * (count - 1))
        chain = cs.blockcat([[corner, cs.MX(STATES, STATES)], [states, cs.MX(STATES * (count - 1), STATES)]])
        chain -= cs.DM.eye(STATES * count)
        turns = cs.diagcat(*[s[:, STATES:] for s in slopes])
        end = cs.horzcat(cs.MX(off.shape[0], STATES * (count - 1)), by_last)
        rest = cs.MX(off.shape[0], CONTROLS * count)
        unknowns, conditions = cs.veccat(x, u), cs.veccat(gaps, off)
        slope = cs.vertcat(cs.horzcat(chain, turns), cs.horzcat(end, rest))
        jacobian = cs.Function("jac_g", [unknowns, cs.MX.sym("p", 0)], [conditions, slope], ["x", "p"], ["g", "jac"])
        ipopt = {
            "hessian_approximation": "limited-memory",
            "max_cpu_time": cap_s,
            "max_iter": 3000,
            "tol": 1e-5,
            "constr_viol_tol": 1e-9,
            "print_level": 0,
            "sb": "yes",
        }
        self.solver = cs.nlpsol(
            "shooting",
            "ipopt",
            {"x": unknowns, "f": interval_s * cs.sumsqr(u), "g": conditions},
            {"ipopt": ipopt, "jac_g": jacobian, "print_time": False},
        )

    def _arrival(self) -> Any:
        """Return what is left to the goal, and its derivative by the last state."""
        x = cs.SX.sym("x", STATES)
        off = [x[:3] - self.last[:3]]
        for k in (3, 7, 11):
            w, v = self.last[k], cs.SX(cs.DM(self.last[k + 1 : k + 4]))
            off.append(quaternion_product(cs.vertcat(w, -v), x[k : k + 4])[1:])
        out = cs.vertcat(*off)
        return cs.Function("arrival", [x], [out, cs.jacobian(out, x)])

    def simulated_error(self, rates: np.ndarray) -> float:
        """Return the largest of position [L] and angles that the model's own simulation ends with."""
        swum = self.one.mapaccum(self.count)(self.first, rates.T, np.full((1, self.count), self.interval_s))
        off = np.array(self._arrival()(swum[:, -1])[0]).reshape(4, 3)
        return float(max(np.linalg.norm(off[0]), *(2.0 * np.linalg.norm(off[1:], axis=1))))

    def solve(self, rng: np.random.Generator) -> np.ndarray:
        """Return the controls that IPOPT ends with from a random start. Shape (count, 6)."""
        n = self.count
        turns = rng.integers(1, max(2, int(n * self.interval_s / 4.0) + 1), size=(CONTROLS, 1))
        phase = rng.uniform(0.0, 2.0 * np.pi, (CONTROLS, 1))
        rate = rng.uniform(0.0, 0.8, (CONTROLS, 1)) * np.sin(2.0 * np.pi * turns * (np.arange(n) + 0.5) / n + phase)
        swum = self.one.mapaccum(n)(self.first, rate, np.full((1, n), self.interval_s))
        bounds = np.concatenate([np.full(STATES * n, np.inf), np.ones(CONTROLS * n)])
        found = self.solver(x0=cs.veccat(swum, rate), lbx=-bounds, ubx=bounds, lbg=0.0, ubg=0.0)
        return np.array(found["x"]).ravel()[STATES * n :].reshape(n, CONTROLS)


def answer(settings: Settings, query: Query, cap_s: float, seed: int) -> Answer | None:
    """Return what the first start that arrives comes to, or the one that ends nearest when the time is up.

    Args:
        settings: How intervals and horizons are chosen.
        query: The query.
        cap_s: The processor time it has [s].
        seed: Of the starts.
    """
    rng, over = np.random.default_rng(seed), time.process_time() + cap_s
    model, best, least, k = Model(query.swimmer), None, np.inf, 0
    while (left := over - time.process_time()) > 0.0 and least > ARRIVED:
        seconds = estimated_time(query) * settings.horizons[k % len(settings.horizons)]
        interval = settings.intervals_s[seconds > LONG_S]
        count = int(np.ceil(seconds / interval))
        program = Shooting(query, model, count, interval, min(left, cap_s / len(settings.horizons)))
        rates = program.solve(rng)
        if (off := program.simulated_error(rates)) < least:
            best, least = Answer(np.full(count, interval), rates), off
        k += 1
    return best
