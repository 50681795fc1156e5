"""The information that a planned measurement would bring on the effects, from the model alone.

The model is linearised where the planned shots would be; sensitivities need no data. The expected discrimination is the
rise of chi^2 with a look-alike in the place of the effect, everything else fitted again.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.information import solved
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.linearised_shot import linearise_shot
from platform_daemon.diagnosis.regression.score_test import score_table
from platform_daemon.diagnosis.shots.shot import PreparedShot, grids_for, whitening_for
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

_LIMITS = THRESHOLDS.findings
_QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

PlannedShot = tuple[PreparedShot, FitState]
Plan = Callable[[PreparedShot, FitState], PlannedShot | None]


def _half_amplitude(prepared: PreparedShot, state: FitState) -> PlannedShot:
    return prepared, replace(state, dynamics=replace(state.dynamics, amplitude=0.5 * state.dynamics.amplitude))


def _twice_as_long(prepared: PreparedShot, state: FitState) -> PlannedShot:
    record = prepared.shot.record
    last = 2 * prepared.grids[-1].last * prepared.grids[-1].factor
    wider = replace(record, samples=np.zeros((record.channels, last)), valid_to=last)
    shot, f_nat_hz = replace(prepared.shot, record=wider), state.dynamics.w / (2.0 * math.pi)
    grids = grids_for(wider, last, f_nat_hz)
    return PreparedShot(shot, state, grids, whitening_for(shot, grids, f_nat_hz)), state


def _turned(prepared: PreparedShot, state: FitState) -> PlannedShot | None:
    observation = state.observation
    if not isinstance(observation, DipoleObservation):
        return None
    return prepared, replace(state, observation=replace(observation, rotation=_QUARTER_TURN @ observation.rotation))


def _repeated(prepared: PreparedShot, state: FitState) -> PlannedShot:
    return prepared, state


# By the measurement's key: how a shot of it would be, and how many there would be for every present one.
PLANS: dict[str, tuple[Plan, float]] = {
    "second_amplitude": (_half_amplitude, 1.0),
    "longer_window": (_twice_as_long, 1.0),
    "turn_90_deg": (_turned, 1.0),
    "more_shots": (_repeated, _LIMITS.more_shots_ratio),
}


def discrimination(
    at: JointFit, effect: Candidate, confounders: Sequence[Candidate], key: str, pool: Executor
) -> list[float] | None:
    """Standard deviations by which the present shots with those of a plan would set an effect apart from each rival.

    None for a measurement without a plan, and where the planned shots cannot be: a motion that dies too soon.
    """
    if key not in PLANS or effect not in at.hypothesis.common:
        return None
    plan, copies = PLANS[key]
    try:
        some = _some(at)
        future = _planned(some, plan)
        if future is None:
            return None
        information = (
            score_table(some, confounders, pool).information
            + copies * score_table(future, confounders, pool).information
        )
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None
    scale = len(at.prepared) / len(some.prepared) / at.noise_factor
    place = dict(zip(at.hypothesis.common, at.hypothesis.slices, strict=True))[effect]
    ends = np.cumsum([at.hypothesis.size, *(r.size for r in confounders)])
    columns = [list(range(int(a), int(b))) for a, b in itertools.pairwise(ends)]
    return [math.sqrt(scale * _exchange(information, at, place, c)) for c in columns]


def _some(at: JointFit) -> JointFit:
    """The first shots, as representatives of all."""
    return replace(
        at,
        prepared=at.prepared[: _LIMITS.planning_shots],
        states=at.states[: _LIMITS.planning_shots],
        linear=at.linear[: _LIMITS.planning_shots],
    )


def _planned(at: JointFit, plan: Plan) -> JointFit | None:
    """The refit of planned shots: only its sensitivities are valid, its residuals are not."""
    shots = [plan(prepared, state) for prepared, state in zip(at.prepared, at.states, strict=True)]
    if any(s is None for s in shots):
        return None
    prepared, states = zip(*(s for s in shots if s is not None), strict=True)
    linear = tuple(linearise_shot(a, at.hypothesis, b, at.strengths) for a, b in zip(prepared, states, strict=True))
    return replace(at, prepared=prepared, states=states, linear=linear)


def _exchange(information: Array, at: JointFit, place: slice, rival: list[int]) -> float:
    """Rise of chi^2 with the rival in the effect's place, all other common strengths fitted again."""
    replaced = list(range(*place.indices(at.hypothesis.size)))
    which = [k for k in range(at.hypothesis.size) if k not in replaced] + rival
    value = at.strengths[replaced]
    caused = information[np.ix_(which, replaced)] @ value
    matrix = information[np.ix_(which, which)]
    whole = float(value @ information[np.ix_(replaced, replaced)] @ value)
    return max(0.0, whole - float(caused @ solved(matrix, caused)))
