"""Parameters of the declared model that are not constant along the ring-down, which shows where the model is wrong.

One parameter at a time is a random walk in time beside the joint fit of the declared model (grey-box identification:
Kristensen, Madsen and Jorgensen, Automatica 40 (2004) 225; time-dependent parameters: Tomassini, Reichert, Kunsch,
Buser, Knutti and Borsuk, J. R. Stat. Soc. C 58 (2009) 679). To first order; all shots that start alike share a trace.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .random_walk import Walk, log_chance_of_walk, walk
from .trace_equations import TraceEquations, stairs
from .trace_shapes import TraceFit, best_shapes

_LIMITS = THRESHOLDS.findings
_LEVEL = math.log(_LIMITS.moving_p)


@dataclass(frozen=True, kw_only=True)
class ParameterTrace:
    """One parameter along the ring-down of shots that start alike, at the knots, (n,).

    amplitude, peak_speed: of the swing there, rad and rad/s. value, std: in the parameter's unit.
    """

    time_s: Array
    amplitude: Array
    peak_speed: Array
    value: Array
    std: Array


@dataclass(frozen=True, kw_only=True)
class MovingParameter:
    """A parameter of the declared model that is not constant along the ring-down.

    Attributes:
        name: public name.
        log_p: log p-value of its motion given those that come before it.
        share: of what the declared model leaves over that its motion (with those before it) takes.
        fit: what it goes with.
        alike: other parameters whose motion would explain as much.
        traces: one for each group of shots that start alike.
    """

    name: str
    log_p: float
    share: float
    fit: TraceFit
    alike: tuple[str, ...]
    traces: tuple[ParameterTrace, ...]


def moving_parameters(at: JointFit, pool: Executor) -> tuple[MovingParameter, ...]:
    """Those that move, the one that explains most first; empty where the motion cannot be followed."""
    try:
        return _found(at, TraceEquations(at, pool))
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return ()


def _found(at: JointFit, equations: TraceEquations) -> tuple[MovingParameter, ...]:
    """One parameter after the other, each given those before it."""
    found: list[MovingParameter] = []
    chosen: list[int] = []
    while len(chosen) < len(equations.moving):
        sure = _sure(equations, chosen)
        if not sure:
            break
        after = min((equations.residual_noise([*chosen, m]) for m in sure), key=lambda x: x.factor).factor
        fits = {m: best_shapes(*equations.schur_complement(m, chosen), after, equations.courses) for m in sure}
        first = max(sure, key=lambda m: fits[m].merit)
        near = max(_LIMITS.alike_chi2, _LIMITS.alike_share * fits[first].merit)
        alike = [m for m in sure if m != first and fits[m].merit > fits[first].merit - near]
        found.append(
            MovingParameter(
                name=equations.moving[first].name,
                log_p=sure[first],
                share=_share(at, equations.gain([*chosen, first])),
                fit=fits[first],
                alike=tuple(equations.moving[m].name for m in alike),
                traces=_traces(at, equations, first, walk(*equations.schur_complement(first, chosen), after), after),
            )
        )
        chosen.append(first)
    return tuple(found)


def log_chances(equations: TraceEquations, chosen: Sequence[int] = ()) -> dict[int, float]:
    """Log p-values of the motion of all other parameters, given those chosen."""
    left = [m for m in range(len(equations.moving)) if m not in chosen]
    rest = {m: equations.residual_noise([*chosen, m]) for m in left}
    return {m: log_chance_of_walk(*equations.schur_complement(m, chosen), rest[m].factor, rest[m].values) for m in left}


def _sure(equations: TraceEquations, chosen: Sequence[int]) -> dict[int, float]:
    """Those that move beyond chance, and beyond the digits of first-order answers."""
    before, chances = equations.gain(chosen), log_chances(equations, chosen)
    enough = {m for m in chances if equations.gain([*chosen, m]) - before > _LIMITS.moving_share * before}
    return {m: p for m, p in chances.items() if m in enough and p < _LEVEL - math.log(len(chances))}


def _share(at: JointFit, gain: float) -> float:
    """Of the excess of chi^2 over that of noise."""
    return min(1.0, gain / max(at.chi2 - at.dof, gain, 1e-300))


def _traces(at: JointFit, equations: TraceEquations, m: int, moved: Walk, factor: float) -> tuple[ParameterTrace, ...]:
    """Values at the knots: the walk, and the response of the shots' own values to it."""
    out, begin, unit = [], 0, equations.moving[m].unit
    place = equations.moving[m].place
    for group, course, shots in zip(equations.groups, equations.courses, equations.shots, strict=True):
        n = course.time_s.size
        steps = slice(begin, begin + n - 1)
        begin += n - 1
        follows = np.mean([r.follows[m, m * n : (m + 1) * n] for r in shots], axis=0)
        to_knots = (np.eye(n) + follows[None, :]) @ stairs(n - 1)
        own = np.mean([_value(at, k, place) for k in group])
        value = own + to_knots @ moved.steps[steps]
        variance = np.einsum("ij,jk,ik->i", to_knots, moved.covariance[steps, steps], to_knots)
        variance += factor * float(np.sum([r.variance[m] for r in shots])) / len(shots) ** 2
        std = np.sqrt(np.maximum(variance, 0.0))
        out.append(
            ParameterTrace(
                time_s=course.time_s,
                amplitude=course.amplitude,
                peak_speed=course.peak_speed,
                value=unit * value,
                std=unit * std,
            )
        )
    return tuple(out)


def _value(at: JointFit, k: int, place: int) -> float:
    """Of a parameter of a shot's state, internal unit."""
    state = at.states[k]
    values = (state.dynamics.theta, state.dynamics.w, state.dynamics.amplitude, *state.dynamics.values)
    if place < len(values):
        return values[place]
    return float(state.offsets[0]) if place == state.size - 1 else float(getattr(state.observation, "m_r", math.nan))
