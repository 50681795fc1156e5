"""Every tuned number of the estimation, in one place: `THRESHOLDS`.

A tuned number is one that somebody chose: a limit, a count, a tolerance, a length. Mathematical constants (the
tableau of a Runge-Kutta method, the coefficients of a spline) are none, and stay where they are used. A module takes
its section once, `LIMITS = THRESHOLDS.noise`; compiled kernels see module-level constants only, so their modules bind
each number that a kernel needs.

screening: Records, windows and sliding windows.
noise: The measurement of noise.
least_squares: Start values, minimisation and passes over samples.
physics: The computed motion.
rigid_rotor: The rotor of five degrees of freedom.
rotor_correction: The correction of one-angle fits for a manufacturing error.
goodness_of_fit: The judgement of a fit.
applications: Calibration, harmonic estimator and Cramer-Rao bound.
tuned: How a tuned number is declared.

tests/estimation/test_thresholds.py counts the numbers that are left elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from .applications import CalibrationThresholds, CramerRaoThresholds, HarmonicEstimatorThresholds
from .goodness_of_fit import GoodnessOfFitThresholds
from .least_squares import LeastSquaresThresholds, StartValueThresholds
from .noise import NoiseThresholds
from .physics import PhysicsThresholds
from .rigid_rotor import RigidRotorThresholds
from .rotor_correction import RotorCorrectionThresholds
from .screening import ScreeningThresholds


@dataclass(frozen=True, kw_only=True)
class Thresholds:
    """The tuned numbers by the part of the estimation that uses them."""

    screening: ScreeningThresholds = field(default_factory=ScreeningThresholds)
    noise: NoiseThresholds = field(default_factory=NoiseThresholds)
    start_values: StartValueThresholds = field(default_factory=StartValueThresholds)
    least_squares: LeastSquaresThresholds = field(default_factory=LeastSquaresThresholds)
    physics: PhysicsThresholds = field(default_factory=PhysicsThresholds)
    rigid_rotor: RigidRotorThresholds = field(default_factory=RigidRotorThresholds)
    rotor_correction: RotorCorrectionThresholds = field(default_factory=RotorCorrectionThresholds)
    goodness_of_fit: GoodnessOfFitThresholds = field(default_factory=GoodnessOfFitThresholds)
    calibration: CalibrationThresholds = field(default_factory=CalibrationThresholds)
    harmonic_estimator: HarmonicEstimatorThresholds = field(default_factory=HarmonicEstimatorThresholds)
    cramer_rao: CramerRaoThresholds = field(default_factory=CramerRaoThresholds)


THRESHOLDS = Thresholds()
