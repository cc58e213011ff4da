"""What any gear does to a rigid joint's parameters though its recording does not show it: it yields, and loses torque.

Behind a compliance c the link lags by c tau, tau what is transmitted: to first order the torque is then less by
c (J tau'' + g'(q) tau), and a joint that sags under its weight has another one. A gear loses a share of what it
transmits, which a slow motion has in its dry friction and its inertia, with nothing left over.

An adversary's pick and place: 3 % of the load lost, J 2.7 % and 5 standard deviations off, FS 14 % and 7; soft joints
in slow moves, MY 0.7 % and 8.
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.estimation.unseen_effects import opened_by
from flex_ident.filtering.spectral import Complexes
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.recording import Floats
from flex_ident.simulation.terms import GRAVITY

LOST = 0.03
"""Share of the transmitted torque that a gear may lose, one standard deviation. Set by hand: a stage of planetary gears
loses 2 to 3 %, harmonic drives as much beside their friction without load, worm gears more."""
MODE_HZ = 6.0
"""Frequency at which all of the inertia would swing behind the compliance of one standard deviation. Set by hand, for
arms of robots. What the first order has above it is damped."""


def gear_covariance(solver: SteadyFit, fit: Fit) -> Floats | None:
    """What it leaves open of the free values (p, p); None for a joint whose spring and losses are in the model."""
    problem, values = solver.problem, fit.values
    if not problem.rigid or "FS" not in fit.free:
        return None
    position, inertia = problem.motion.position, values["J"]
    mx, my = GRAVITY * values.get("MX", 0.0), GRAVITY * values.get("MY", 0.0)
    weight = mx * np.cos(position) + my * np.sin(position)
    torque = inertia * problem.motion.acceleration + weight
    slope = my * np.cos(position) - mx * np.sin(position)
    lost = problem.reduced(LOST * np.abs(torque) * problem.friction_share(problem.terms(values)))

    natural = 2.0 * math.pi * MODE_HZ

    def twice(omega: Floats) -> Complexes:
        return np.asarray(-(omega**2) / (1.0 + (omega / natural) ** 2), complex)

    # Apart, as how much of the inertia is behind the compliance is not known.
    sagging = problem.reduced(slope * weight) / inertia / natural**2
    swinging = problem.reduced_through(torque, twice) + problem.reduced(slope * (torque - weight)) / inertia
    swinging /= natural**2
    columns = np.column_stack([solver.whitened((change,), fit.whitenings) for change in (-lost, sagging, swinging)])
    return opened_by(fit, columns) if np.isfinite(columns).all() else None
