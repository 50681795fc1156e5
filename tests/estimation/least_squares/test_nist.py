"""NIST's certified nonlinear regression problems, through the very optimiser that fits ring-downs.

`fit_progressively` and `solve_step` know nothing of magnets: they see a state that can be moved, its normal equations,
and which parameters are free. Here the state is a vector of regression parameters behind three dummies that are held
(phase, frequency, amplitude in a ring-down), and the normal equations come from the regression's own derivatives. A
leading factor b1 is treated as the fit treats free gains: every pass puts it at its best for the other parameters, and
it stays a column of the normal equations.
"""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from platform_daemon.estimation.least_squares.gauss_newton import NormalEquations, covariance
from platform_daemon.estimation.least_squares.problem import Evaluation, NoConvergenceError
from platform_daemon.estimation.least_squares.progressive import fit_progressively
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError, MotionParameters
from tests.kit.nist_problems import PROBLEMS

HELD = 3
# Far below the real scatter, so that the fixed tolerance on the fall of chi^2 asks for many digits.
FINENESS = 1e-3


def polynomial(b, x):
    return sum(c * x**k for k, c in enumerate(b))


def rational(top, bottom):
    return lambda b, x: polynomial(b[:top], x) / polynomial([1.0, *b[top : top + bottom]], x)


MODELS = {
    "Misra1a": lambda b, x: b[0] * (1 - np.exp(-b[1] * x)),
    "Thurber": rational(4, 3),
    "MGH09": lambda b, x: b[0] * (x**2 + x * b[1]) / (x**2 + x * b[2] + b[3]),
    "Eckerle4": lambda b, x: b[0] / b[1] * np.exp(-0.5 * ((x - b[2]) / b[1]) ** 2),
    "Hahn1": rational(4, 3),
    "Rat42": lambda b, x: b[0] / (1 + np.exp(b[1] - b[2] * x)),
    "Rat43": lambda b, x: b[0] / (1 + np.exp(b[1] - b[2] * x)) ** (1 / b[3]),
    "Bennett5": lambda b, x: b[0] * (b[1] + x) ** (-1 / b[2]),
    "BoxBOD": lambda b, x: b[0] * (1 - np.exp(-b[1] * x)),
    "MGH10": lambda b, x: b[0] * np.exp(b[1] / (x + b[2])),
}


@dataclass(frozen=True)
class Vector:
    """The optimiser's state for a regression: what fit_progressively reads of a FitState."""

    b: np.ndarray
    dynamics = MotionParameters(w=1.0, theta=0.0, amplitude=1.0, values=())
    observation = SimpleNamespace(ties_amplitude=True, size=0, bend=lambda step: 0.0)

    @property
    def size(self):
        return HELD + self.b.size

    def moved(self, step):
        return replace(self, b=self.b + step[HELD:])


# Problems whose first parameter is a factor of the whole function.
GAIN_FIRST = {"Misra1a", "Eckerle4", "Rat42", "Rat43", "Bennett5", "BoxBOD", "MGH10"}


class Regression:
    """What fit_progressively reads of a FitProblem."""

    model = RingDownModel("regression", ())
    first = 0

    def __init__(self, name):
        self.certified, self.function = PROBLEMS[name], MODELS[name]
        self.has_gain = name in GAIN_FIRST
        n, k = self.certified.y.size, len(self.certified.values)
        self.record = SimpleNamespace(sampling_rate_hz=1.0, dt_s=1.0, channels=1)
        self.sd = FINENESS * np.sqrt(self.certified.squares / (n - k))
        self.free = np.array([False] * HELD + [True] * k)
        self.n, self.passes = n, 0

    def bend(self, at, step, last):
        return np.inf  # unknown: only the predicted fall of chi^2 counts

    def after(self, at, step):
        return at.normal

    def evaluate(self, state, last, stride=1, digits=0.0):
        self.passes += 1
        state = self.with_best_gain(state)
        jacobian = np.zeros((self.n, state.size))
        # Complex steps: derivatives exact to rounding without writing them down.
        for k in range(state.b.size):
            shifted = state.b.astype(complex)
            shifted[k] += 1e-30j
            jacobian[:, HELD + k] = self.function(shifted, self.certified.x).imag / 1e-30
        with np.errstate(all="ignore"):
            residual = self.certified.y - self.function(state.b, self.certified.x)
        if not (np.all(np.isfinite(residual)) and np.all(np.isfinite(jacobian))):
            raise LostTrajectoryError("the regression function is not finite here")
        squares = np.array([residual @ residual])
        weight = self.sd**-2.0
        normal = NormalEquations(
            chi2=float(weight * squares[0]),
            chi2_by_channel=weight * squares,
            squares_by_channel=squares,
            gradient=weight * jacobian.T @ residual,
            matrix=weight * jacobian.T @ jacobian,
            samples=self.n,
        )
        return Evaluation(state, None, normal)

    def with_best_gain(self, state):
        if not self.has_gain:
            return state
        shape = self.function(np.array([1.0, *state.b[1:]]), self.certified.x)
        if not (np.all(np.isfinite(shape)) and np.any(shape)):
            raise LostTrajectoryError("the regression function is not finite here")
        return replace(state, b=np.array([shape @ self.certified.y / (shape @ shape), *state.b[1:]]))


def digits(value, certified):
    """Correct decimal digits, at most 11 as certified (NIST's log relative error)."""
    return float(np.min(-np.log10(np.maximum(np.abs(np.array(value) / np.array(certified) - 1.0), 1e-11))))


def solved(name, start):
    problem = Regression(name)
    state = Vector(np.array(problem.certified.starts[start]))
    return problem, fit_progressively(problem, state, start_periods=1e9, last=problem.n)


def check(problem, best):
    """The parameters, their errors and the residual, to four certified digits and more."""
    certified = problem.certified
    normal = problem.evaluate(best.state, problem.n).normal
    errors, _ = covariance(normal, problem.free)
    sd = np.sqrt(np.diag(errors)) / FINENESS
    found = digits(best.state.b, certified.values)
    print(f"{problem.passes} passes, {found:.1f} digits, of the errors {digits(sd, certified.sd):.1f}")
    assert found > 4
    assert digits(sd, certified.sd) > 4
    assert digits(normal.squares_by_channel, certified.squares) > 6


@pytest.mark.parametrize("name", sorted(PROBLEMS))
def test_certified_values_and_errors_are_found_from_the_near_start(name):
    check(*solved(name, 1))


# From afar four valleys are too flat or too bent for 30 iterations with a damping of at least
# 1e-4 of each parameter's own curvature. Ring-downs start near: what counts is that nothing false comes out.
GIVEN_UP = {"Eckerle4", "MGH09", "MGH10", "Thurber"}


@pytest.mark.filterwarnings("ignore:.*(overflow|invalid value|divide by zero):RuntimeWarning")
@pytest.mark.parametrize("name", sorted(PROBLEMS))
def test_a_far_start_leads_to_the_certified_values_or_is_given_up_but_never_to_others(name):
    try:
        problem, best = solved(name, 0)
    except (NoConvergenceError, LostTrajectoryError, np.linalg.LinAlgError):
        assert name in GIVEN_UP
        return
    check(problem, best)
