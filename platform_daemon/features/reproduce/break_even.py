"""Where the jewel should become more precise than the thread, by the paper's own numbers (fig:noise_plot).

At a level L of white noise an unbiased fit scatters by no less than the root of s^2 + (k L)^2: s as published at the
own noise (tab:model_params_fit_result), k by the Cramer-Rao bound at the published means of N50.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from platform_daemon.estimation.cramer_rao import MeasurementPlan, predict_precision
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.thresholds import THRESHOLDS
from platform_daemon.features.fit.series.orientation import error_angle

JEWEL_N50 = {
    "f_nat_hz": 212.93,
    "m_r_am2": 12.262e-3,
    "lambda_per_s": 0.2465,
    "tf_over_i_rad_per_s2": 1063.0,
    "phi_max_rad": math.radians(52.4),
    "psi_start_rad": math.radians(219.1),
}
"""Means of tab:model_params_fit_result; lambda is held."""
THREAD_N50 = {
    "f_nat_hz": 215.53,
    "m_r_am2": 11.647e-3,
    "lambda_per_s": 0.2466,
    "phi_max_rad": math.radians(21.8),
    "psi_start_rad": math.radians(333.7),
}
PRINTED_BREAK_EVEN_AM2_PER_S = {"f_nat_hz": 0.17, "orientation": 0.54}
"""fig:noise_plot."""
_PUBLISHED = {"f_nat_hz": (0.08, 0.13), "orientation": (0.012, 0.132)}  # thread, jewel; deviation Hz, mean error deg
_OWN_AM2_PER_S = (14e-3, 21e-3, 55e-3)  # footnote of fig:noise_plot
_RATE_HZ = 125e6 / 2048.0  # sampling frequency of the I/O card
_POSE = dict(zip(RODRIGUES, (0.0, 0.0, -math.pi / 2.0), strict=True))  # w along z, v along x
_DRAWN = 20_000


@dataclass(frozen=True)
class ExpectedBreakEven:
    """Of one quantity.

    Attributes:
        level_am2_per_s: where the two curves cross.
        thread_share: by what the thread's bound would have to be multiplied for a crossing at the printed level.
        jewel_needed: deviation (Hz) or mean error (deg) of the jewel with which they would cross there.
    """

    quantity: str
    level_am2_per_s: float
    thread_share: float
    jewel_needed: float


def expected_break_even(quantity: str) -> ExpectedBreakEven:
    """Of f_nat_hz or orientation, from the paper's numbers alone."""
    (thread, jewel), printed = _PUBLISHED[quantity], PRINTED_BREAK_EVEN_AM2_PER_S[quantity]
    k_thread, k_jewel = (_of_white_noise(variant, (1.0, 1.0, 1.0))[quantity] for variant in ("thread", "jewel"))
    apart, slopes = jewel**2 - thread**2, k_thread**2 - k_jewel**2
    return ExpectedBreakEven(
        quantity=quantity,
        level_am2_per_s=math.sqrt(apart / slopes),
        thread_share=math.sqrt(apart / printed**2 + k_jewel**2) / k_thread,
        jewel_needed=math.sqrt(thread**2 + slopes * printed**2),
    )


def smallest_error_deg(variant: str) -> float:
    """Mean orientation error of a resonator in N50 by the bound, were the paper's own noise white, deg."""
    return _of_white_noise(variant, _OWN_AM2_PER_S)["orientation"]


@cache
def break_even_text() -> tuple[str, str]:
    """Why the printed levels do not follow from the paper's own numbers, of f_nat and of the orientation."""
    f, tilt = expected_break_even("f_nat_hz"), expected_break_even("orientation")
    return (
        f"fig:noise_plot (a): with the printed deviations of 0.08 and 0.13 Hz and the Cramer-Rao bound of N50 the "
        f"jewel is more precise from {f.level_am2_per_s:.2g} A m2/s on, printed is 0.17; for that its deviation would "
        f"have to be {f.jewel_needed:.5f} Hz, or the thread's fits scatter {f.thread_share:.2g} times as much as the "
        f"bound",
        f"fig:noise_plot (b): with the printed mean errors of 0.012 and 0.132 deg it is from "
        f"{tilt.level_am2_per_s:.2g} A m2/s on, printed is 0.54; for that the jewel's error would have to be "
        f"{tilt.jewel_needed:.2f} deg, or the thread's fits {tilt.thread_share:.2g} times the bound, which no unbiased "
        f"fit can; the thread's printed 0.012 deg, too, lies below the {smallest_error_deg('thread'):.3f} deg of white "
        f"noise of its 14, 21 and 55 mA m2/s",
    )


def _of_white_noise(variant: str, noise_sd: tuple[float, ...]) -> Mapping[str, float]:
    """Deviation of f_nat in Hz and mean orientation error in deg by the bound."""
    means, held = (JEWEL_N50, ("lambda_per_s",)) if variant == "jewel" else (THREAD_N50, ())
    plan = MeasurementPlan(variant, means | _POSE, noise_sd, _RATE_HZ, held)
    found = predict_precision(plan, THRESHOLDS.screening.n50_s)
    places = [found.names.index(name) for name in RODRIGUES]
    pose = np.array(list(_POSE.values()))
    covariance = found.covariance[np.ix_(places, places)]
    # The error angle is linear in small errors: drawn at a hundredth, as 1 A m2/s may turn the thread by a degree.
    drawn = np.random.default_rng(1).multivariate_normal(np.zeros(3), covariance, size=_DRAWN)
    error_rad = 100.0 * float(error_angle(pose + 0.01 * drawn, pose).mean())
    return {"f_nat_hz": found.sd["f_nat_hz"], "orientation": math.degrees(error_rad)}
