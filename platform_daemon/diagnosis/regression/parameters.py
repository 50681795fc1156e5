"""Public parameters of all shots under a hypothesis, and the disagreement of short and long windows."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student_t

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.least_squares.gauss_newton import NormalEquations
from platform_daemon.estimation.least_squares.public_parameters import PublicParameters, propagate_to_public
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.parameters import Estimate
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.result import FitResult

from .information import inverse
from .joint_fit import JointFit
from .prediction import non_torque_signal, own_sizes, window_of

_LIMITS = THRESHOLDS.regression
_ANGLES = {"psi_start_rad"}
Parameters = Mapping[str, Estimate]


@dataclass(frozen=True, kw_only=True)
class Mean:
    """Mean over the shots, its standard deviation, and the scatter between shots.

    The standard deviation is that of the shots' own errors, which average out, with that of the common strengths,
    which does not.
    """

    value: float
    std: float
    scatter: float | None


def public_parameters(at: JointFit, k: int, *, common: bool = True) -> PublicParameters:
    """Public parameters of shot k, with errors that a residual of more than noise widens.

    common: errors include those of the common strengths.  Raises LostTrajectoryError.
    """
    linear, state = at.linear[k], at.full_state(k)
    mask = at.hypothesis.declared(state.size)
    mask[np.flatnonzero(mask)[~linear.free]] = False
    places, factors = at.hypothesis.strength_places(), at.hypothesis.factors(at.states[k])
    carriers = zip(places, at.hypothesis.carriers(), at.strengths, strict=False)
    shares = [(place, 3 + c, strength) for place, c, strength in carriers if c is not None]
    whole = np.zeros((state.size, state.size))
    whole[np.ix_(mask, mask)] = linear.own_covariance()[np.ix_(linear.free, linear.free)]
    for place, carrier, strength in shares:
        whole[place] += strength * whole[carrier]
        whole[:, place] += strength * whole[:, carrier]
    if common and at.hypothesis.size:
        follow = np.zeros((state.size, at.hypothesis.size))
        within = np.linalg.lstsq(linear.q @ linear.triangle, linear.columns, rcond=None)[0] * linear.scale[:, None]
        follow[mask] = -within
        # A torque moves the start that is published directly too, not only through the state that follows it.
        follow[places, np.arange(len(places))] = factors
        for place, carrier, strength in shares:
            follow[place] += strength * follow[carrier]
        whole += follow @ at.covariance @ follow.T
        mask[places] = True
    matrix = np.zeros((state.size, state.size))
    matrix[np.ix_(mask, mask)] = inverse(at.noise_factor * whole[np.ix_(mask, mask)])
    nothing = np.zeros(state.offsets.size)
    normal = NormalEquations(
        chi2=0.0,
        chi2_by_channel=nothing,
        squares_by_channel=nothing,
        gradient=np.zeros(state.size),
        matrix=matrix,
        samples=0,
    )
    return propagate_to_public(at.hypothesis.augmented, state, normal, mask)


def means(at: JointFit) -> dict[str, Mean]:
    """Mean public parameters of all shots; angles on the circle."""
    rows, alone = [], []
    for k in range(len(at.linear)):
        try:
            both = public_parameters(at, k).parameters, public_parameters(at, k, common=False).parameters
        except (LostTrajectoryError, np.linalg.LinAlgError):
            continue
        rows.append(both[0])
        alone.append(both[1])
    names = [n for n, e in alone[0].items() if e.std is not None] if rows else []  # strengths are reported elsewhere
    return {name: _mean(name, rows, alone) for name in names}


def with_scales(found: Mapping[str, Mean], moved: Sequence[tuple[Mapping[str, Mean], float]]) -> dict[str, Mean]:
    """Parameters whose errors count those of hidden scales, which the fit holds.

    moved: for each scale the parameters with it moved, and how many such moves a standard deviation has.
    """
    out = {}
    for name, m in found.items():
        off = [times * _difference(name, o[name].value, m.value) for o, times in moved if name in o]
        out[name] = replace(m, std=math.hypot(m.std, *off))
    return out


def widened(found: Mapping[str, Mean], alike: Sequence[tuple[Mapping[str, Mean], float]]) -> dict[str, Mean]:
    """Parameters with standard deviations that span what other explanations would make of them.

    alike: parameters of every explanation that cannot be excluded, and its rise of chi^2: it is the root of this rise
    in standard deviations away, as on a profile of the likelihood.
    """
    out = {}
    for name, m in found.items():
        off = [(_difference(name, o[name].value, m.value), rise) for o, rise in alike if name in o]
        std = max([m.std, *(abs(d) / math.sqrt(max(rise, 1.0)) for d, rise in off)])
        out[name] = replace(m, std=std)
    return out


def _difference(name: str, a: float, b: float) -> float:
    """Of two values; of angles, on the circle."""
    return math.remainder(a - b, 2.0 * math.pi) if name in _ANGLES else a - b


def _mean(name: str, rows: Sequence[Parameters], alone: Sequence[Parameters]) -> Mean:
    values = np.array([row[name].value for row in rows])
    stds = np.array([row[name].std or 0.0 for row in rows])
    own = np.array([row[name].std or 0.0 for row in alone])
    common = float(np.sqrt(np.maximum(stds**2 - own**2, 0.0)).mean())
    centre = 0.0
    if name in _ANGLES:
        centre = math.atan2(np.sin(values).mean(), np.cos(values).mean())
        values = np.remainder(values - centre + math.pi, 2.0 * math.pi) - math.pi
    mean = centre + float(values.mean())
    scatter = float(values.std(ddof=1)) if values.size > 1 else None
    mean = mean % (2.0 * math.pi) if name in _ANGLES else mean
    return Mean(value=mean, std=math.hypot(float(np.sqrt(np.sum(own**2))) / values.size, common), scatter=scatter)


@dataclass(frozen=True, kw_only=True)
class WindowDifference:
    """Mean of N50 - D30 of a parameter over the shots, and its standard error.

    dof: of the scatter that the standard error is of; None: it is of the shots' own noise.
    """

    value: float
    std: float
    dof: int | None = None

    @classmethod
    def of_shots(cls, differences: Array, noise_variances: Array) -> WindowDifference:
        """From N50 - D30 of each shot, (shots,), and what noise alone would make of each."""
        count = differences.size
        if count >= _LIMITS.paired_shots:
            error, dof = float(differences.std(ddof=1)) / math.sqrt(count), count - 1
        else:
            error, dof = math.sqrt(max(float(np.sum(noise_variances)), 1e-300)) / count, None
        return cls(value=float(differences.mean()), std=error, dof=dof)

    @property
    def errors(self) -> float:
        """How many of its errors it is; infinite where the shots differ by exactly the same."""
        if self.std > 0.0:
            return abs(self.value) / self.std
        return math.inf if self.value else 0.0

    @property
    def sigma(self) -> float:
        """How significant it is, in standard deviations of a normal distribution.

        A scatter of few shots is known only roughly, so that several of its errors may be chance: the number is that
        whose tail is as likely as Student's.
        """
        if self.dof is None or not 0.0 < self.errors < math.inf:
            return self.errors
        return float(norm.isf(max(float(student_t.sf(self.errors, self.dof)), sys.float_info.min)))


def window_differences(at: JointFit, pool: Executor) -> dict[str, WindowDifference]:
    """N50 - D30 by parameter: both windows fitted with the strengths held.

    Empty where a window cannot be fitted (an angle, a record too short).
    """
    pairs = list(pool.map(lambda k: _both(at, k), range(len(at.prepared))))
    good = [p for p in pairs if p is not None]
    if not good:
        return {}
    names = [
        n for n in good[0][0].parameters if all(n in p[0].covariance_names and n in p[1].covariance_names for p in good)
    ]
    return {name: _window_difference(name, good) for name in names}


def window_disagreement(at: JointFit, pool: Executor) -> dict[str, float]:
    """How significant N50 - D30 is, in standard deviations, by parameter; see `window_differences`."""
    return {name: one.sigma for name, one in window_differences(at, pool).items()}


def with_what_is_left(
    found: Mapping[str, Mean], at: JointFit, differences: Mapping[str, WindowDifference]
) -> tuple[dict[str, Mean], list[str]]:
    """Parameters of shots that are not explained, whose errors say how far the resonator's constants may be off, and
    sentences that tell which errors contain what.

    What is not explained moves constants from shot to shot and from window to window.  The error of a mean is not below
    what the scatter says, and contains the difference of N50 and D30 where that is no chance.
    """
    names = {"f_nat_hz", "m_r_am2", *(c.name for c in at.hypothesis.model.coefficients)}
    out, by_scatter, by_windows = dict(found), list[str](), list[str]()
    for name in sorted(names & out.keys()):
        m = out[name]
        std = m.std if m.scatter is None else max(m.std, m.scatter / math.sqrt(len(at.prepared)))
        if std > THRESHOLDS.findings.noted_growth * m.std:
            by_scatter.append(name)
        apart = differences.get(name)
        if apart is not None and apart.errors > _LIMITS.windows_differ_sigma:
            if abs(apart.value) > std:
                by_windows.append(name)
            std = math.hypot(std, apart.value)
        out[name] = replace(m, std=std)
    told = ((by_scatter, "the scatter from shot to shot"), (by_windows, "the difference of N50 and D30"))
    return out, [
        f"errors of {', '.join(some)} contain {what}, because not all of the motion is explained"
        for some, what in told
        if some
    ]


def _both(at: JointFit, k: int) -> tuple[FitResult, FitResult] | None:
    prepared, hypothesis = at.prepared[k], at.hypothesis
    if prepared.shot.record.quantity == "angle":
        return None
    record, fixed = clean_record(at, k), held_strengths(at, k)
    model, noise = hypothesis.augmented, prepared.shot.noise
    try:
        short = fit_ring_down(record, model, "n50", noise=noise, fixed=fixed)
        long = fit_ring_down(record, model, "d30", noise=noise, fixed=fixed)
    except ValueError:
        return None
    return (short, long) if short.verdict == long.verdict == "good" else None


def held_strengths(at: JointFit, k: int) -> dict[str, float]:
    """Coefficients of the torque effects by name, to be held in fits of shot k alone."""
    fixed: dict[str, float] = {}
    factors = at.hypothesis.factors(at.states[k])
    for c, strength, factor in zip(at.hypothesis.torques, at.strengths, factors, strict=False):
        assert c.term is not None
        values = [float(strength * factor), *c.hidden]
        fixed |= {q.name: v for q, v in zip(c.term.coefficients, values, strict=True)}
    return fixed


def clean_record(at: JointFit, k: int) -> RingDownRecord:
    """The record of a shot without receiver and additive effects."""
    return replace(at.prepared[k].shot.record, samples=_clean(at, k))


def _clean(at: JointFit, k: int) -> np.ndarray:
    """Samples of a shot without receiver and additive effects; beyond the window as they were."""
    prepared, hypothesis = at.prepared[k], at.hypothesis
    samples = prepared.shot.record.samples
    if not (hypothesis.receivers or any(c.additive for c in hypothesis.effects)):
        return samples
    linear, state = at.linear[k], at.states[k]
    own = own_sizes(hypothesis, linear, at.strengths)
    first, last = window_of(prepared)
    out = samples.copy()
    out[:, first:last] -= non_torque_signal(prepared, hypothesis, state, at.strengths, own)
    return out


def _window_difference(name: str, pairs: Sequence[tuple[FitResult, FitResult]]) -> WindowDifference:
    differences = np.array([short.parameters[name].value - long.parameters[name].value for short, long in pairs])
    if name in _ANGLES:
        differences = np.remainder(differences + math.pi, 2.0 * math.pi) - math.pi
    stds = np.array([[one.parameters[name].std or 0.0 for one in pair] for pair in pairs])
    return WindowDifference.of_shots(differences, stds[:, 0] ** 2 - stds[:, 1] ** 2)
