"""Tuned numbers of calibration, harmonic estimator and Cramer-Rao bound."""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import covered_by, tuned

APPLY = covered_by("calibration/test_apply.py")
ESTIMATOR = covered_by("harmonic_estimator/test_estimator.py")
CRAMER_RAO = covered_by("test_cramer_rao.py")


@dataclass(frozen=True, kw_only=True)
class CalibrationThresholds:
    """How calibrations are made and applied."""

    # Equaliser: equaliser.py
    band_hz: float = tuned(8000.0, "Hz", "up to which the receive chain is undone")
    band_rate_divisor: float = tuned(6.0, "1", "part of the sampling rate, the same")
    equaliser_grid: int = tuned(8192, "points", "of the transform in which the filter is designed")
    lowest_hz: float = tuned(50.0, "Hz", "from which on the filter must be right")
    equaliser_error: float = tuned(
        1e-7, "1", "of the response in the signal band; the best m_r has a relative error of 1e-5", APPLY
    )
    equaliser_reaches: tuple[int, ...] = tuned(
        (16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 1024),
        "samples",
        "of the filter on either side, the shortest that is good enough",
    )
    fade_middle: float = tuned(1.5, "1", "times the band, where the filter is half faded out")
    fade_width: float = tuned(0.15, "1", "times the band, over which it fades out")

    # Reference dipole and drive: phasors.py, receive.py, transmit.py
    segments: int = tuned(
        16, "segments", "of a window; their scatter is the noise where the tone is, whatever its colour"
    )
    segment_periods: float = tuned(1.0, "periods", "in a segment at least")
    segment_samples: int = tuned(8, "samples", "in a segment at least")
    split_rounds: int = tuned(20, "rounds", "of alternating least squares of geometry and response")
    cross_share: float = tuned(
        0.5, "1", "of a channel's largest sensitivity: a larger one on another axis is worth a word"
    )
    coil_scale: float = tuned(0.1, "1", "typical change of L / R, by which the solver scales its steps")

    # Receiver effects: receiver_correction.py
    spline_reach_samples: int = tuned(12, "samples", "after which a quintic spline has forgotten its end")
    compression_steps: int = tuned(8, "steps", "of the fixed point: c u^2 < 0.1 is then exact to 1e-8")
    largest_condition: float = tuned(1e8, "1", "of P, beyond which it is singular")


@dataclass(frozen=True, kw_only=True)
class HarmonicEstimatorThresholds:
    """How a ring-down is read from its harmonics."""

    window_share: float = tuned(2.0 / 3.0, "1", "of the stretch, in each of the two windows", ESTIMATOR)
    kaiser_beta: float = tuned(14.0, "1", "of the windows: side lobes below 1e-5", ESTIMATOR)
    averaging_share: float = tuned(0.9, "1", "of the amplitude, to which its way in the average is limited")
    slope_step_share: float = tuned(1e-4, "1", "of the amplitude: step of the central differences")
    periods: float = tuned(24.0, "periods", "from which the harmonics are read", ESTIMATOR)
    fewest_periods: float = tuned(
        15.0, "periods", "below, the windows no longer separate harmonics from the noise between them", ESTIMATOR
    )
    most_samples: int = tuned(
        2**16, "samples", "looked at for the frequency, so that the cost does not depend on the record"
    )
    between: tuple[float, ...] = tuned(
        (1.5, 2.5, 3.5), "1", "frequencies over the fundamental, where there is only noise"
    )
    passes: int = tuned(5, "passes", "of the demodulation", ESTIMATOR)
    least_snr: float = tuned(4.0, "1", "of the second harmonic, below which the amplitude is not read", ESTIMATOR)
    small_parameter: float = tuned(1e-6, "1", "of the elliptic integrals, below which a series replaces the quotient")


@dataclass(frozen=True, kw_only=True)
class CramerRaoThresholds:
    """How finely a planned measurement is computed."""

    samples_per_period: float = tuned(
        64.0, "samples", "enough for every harmonic that matters; more samples only add up", CRAMER_RAO
    )
    most_samples: int = tuned(4_000_000, "samples", "three arrays of 32 MB; 100 s of 600 Hz")
    most_rotor_samples: int = tuned(500_000, "samples", "of a rotor's record: 0.3 GB for its Jacobian; 36 s of 215 Hz")
    largest_condition: float = tuned(1e12, "1", "of the scaled Fisher matrix, beyond which nothing is determined")
