"""What a measurement that has not been made would tell: its information on the effects, from the model alone.

Shots of the plan are looked at where the present ones would be with it: their sensitivities do not need data. What an
effect would leave over with a look-alike in its place, beside everything else that is fitted, is the discrimination
to be expected.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation import Array, DipoleObservation, FitState, LostTrajectoryError

from ..effects.effect import Candidate
from ..regression.information import solved
from ..regression.joint_fit import JointFit
from ..regression.linearised_shot import linearise_shot
from ..regression.score_test import score_table
from ..shots.shot import PreparedShot, grids_for, whitening_for

_SHOTS = 3  # that stand for all
_QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

PlannedShot = tuple[PreparedShot, FitState]
Plan = Callable[[PreparedShot, FitState], PlannedShot | None]


def _half_amplitude(started: PreparedShot, state: FitState) -> PlannedShot:
    return started, replace(state, dynamics=replace(state.dynamics, amplitude=0.5 * state.dynamics.amplitude))


def _twice_as_long(started: PreparedShot, state: FitState) -> PlannedShot:
    record = started.shot.record
    last = 2 * started.grids[-1].last * started.grids[-1].factor
    wider = replace(record, samples=np.zeros((record.channels, last)), valid_to=last)
    shot, f_nat_hz = replace(started.shot, record=wider), state.dynamics.w / (2.0 * math.pi)
    grids = grids_for(wider, last, f_nat_hz)
    return PreparedShot(shot, state, grids, whitening_for(shot, grids, f_nat_hz)), state


def _turned(started: PreparedShot, state: FitState) -> PlannedShot | None:
    observation = state.observation
    if not isinstance(observation, DipoleObservation):
        return None
    return started, replace(state, observation=replace(observation, rotation=_QUARTER_TURN @ observation.rotation))


def _repeated(started: PreparedShot, state: FitState) -> PlannedShot:
    return started, state


# By the measurement's key: how a shot of it would be, and how many there would be for every present one.
PLANS: dict[str, tuple[Plan, float]] = {
    "second_amplitude": (_half_amplitude, 1.0),
    "longer_window": (_twice_as_long, 1.0),
    "turn_90_deg": (_turned, 1.0),
    "more_shots": (_repeated, 3.0),
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
    scale = len(at.started) / len(some.started) / at.noise_factor
    place = dict(zip(at.hypothesis.common, at.hypothesis.slices, strict=True))[effect]
    ends = np.cumsum([at.hypothesis.size, *(r.size for r in confounders)])
    columns = [list(range(int(a), int(b))) for a, b in itertools.pairwise(ends)]
    return [math.sqrt(scale * _exchange(information, at, place, c)) for c in columns]


def _some(at: JointFit) -> JointFit:
    """The first shots, which stand for all."""
    return replace(at, started=at.started[:_SHOTS], states=at.states[:_SHOTS], linear=at.linear[:_SHOTS])


def _planned(at: JointFit, plan: Plan) -> JointFit | None:
    """The refit of shots to come, as far as sensitivities go; its residuals mean nothing."""
    shots = [plan(started, state) for started, state in zip(at.started, at.states, strict=True)]
    if any(s is None for s in shots):
        return None
    started, states = zip(*(s for s in shots if s is not None), strict=True)
    linear = tuple(linearise_shot(a, at.hypothesis, b, at.strengths) for a, b in zip(started, states, strict=True))
    return replace(at, started=started, states=states, linear=linear)


def _exchange(information: Array, at: JointFit, place: slice, rival: list[int]) -> float:
    """Rise of chi^2 with the rival in the effect's place, everything else that is common fitted beside it."""
    gone = list(range(*place.indices(at.hypothesis.size)))
    which = [k for k in range(at.hypothesis.size) if k not in gone] + rival
    value = at.strengths[gone]
    caused = information[np.ix_(which, gone)] @ value
    matrix = information[np.ix_(which, which)]
    whole = float(value @ information[np.ix_(gone, gone)] @ value)
    return max(0.0, whole - float(caused @ solved(matrix, caused)))
