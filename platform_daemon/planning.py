"""What a planned measurement can tell: the Cramer-Rao bound for a resonator, a deflection, a noise and windows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from drivers.errors import InputError
from drivers.specimen import Specimen
from platform_daemon.analysis import Window
from platform_daemon.estimation.derived import Plan, planned_window_s, predict_precision
from sequences.settle import expected_moment, expected_omega

PAPER_NOISE_AM2_PER_S = (0.014, 0.021, 0.055)  # footnote of the paper's "Primary Results": x, y, z
PAPER_DEFLECTION_DEG = {"thread": 22.8, "jewel": 53.0}  # paper tab:model_params_fit_result, D30


def expected_parameters(specimen: Specimen, phi_max_rad: float, psi_start_rad: float) -> dict[str, float]:
    """Public parameters that a fit of this specimen would find, SI; measured values, else design values.

    Raises InputError for a jewel without a measured T_f/I, because its damping would be unknown.
    """
    m = specimen.measured
    found = {
        "f_nat_hz": expected_omega(specimen) / (2 * math.pi),
        "m_r_am2": expected_moment(specimen),
        "lambda_per_s": m.lambda_per_s,
        "phi_max_rad": phi_max_rad,
        "psi_start_rad": psi_start_rad,
        **dict(zip(("rodrigues_x", "rodrigues_y", "rodrigues_z"), specimen.pose.rodrigues_rad, strict=True)),
    }
    if specimen.variant == "jewel":
        if m.tf_over_i_rad_per_s2 is None:
            remedy = "add measured.tf_over_i_rad_per_s2 to the resonator file"
            raise InputError("the friction of this jewel is not known", where=specimen.name, remedy=remedy)
        found["tf_over_i_rad_per_s2"] = m.tf_over_i_rad_per_s2
    return found


def predict(
    specimen: Specimen,
    windows: Sequence[Window],
    *,
    phi_max_rad: float,
    psi_start_rad: float = 0.0,
    noise_am2_per_s: Sequence[float] = PAPER_NOISE_AM2_PER_S,
    sampling_rate_hz: float = 125e6 / 2048,
    fixed: tuple[str, ...] = (),
) -> dict[str, Any]:
    """Smallest possible standard deviations per window.  Raises InputError if the plan makes no sense."""
    parameters = expected_parameters(specimen, phi_max_rad, psi_start_rad)
    plan = Plan(specimen.variant, parameters, tuple(noise_am2_per_s), sampling_rate_hz, fixed)
    try:
        bounds = [(w, predict_precision(plan, planned_window_s(plan, w))) for w in windows]
    except (ValueError, ArithmeticError) as error:
        remedy = "give three positive noise levels, a window that ends, and a deflection below 90 deg"
        raise InputError("nothing can be predicted for this plan", why=str(error), remedy=remedy) from None
    return {
        "variant": specimen.variant,
        "expected": parameters,
        "noise_sd_am2_per_s": list(noise_am2_per_s),
        "sampling_rate_hz": sampling_rate_hz,
        "windows": [
            {"window": w, "window_s": b.window_s, "std": b.sd, "orientation_rad": b.orientation_rad} for w, b in bounds
        ],
    }
