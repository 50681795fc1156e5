"""What a planned measurement can tell: the Cramer-Rao bound for a resonator, a deflection, a noise and windows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from drivers.errors import InputError
from drivers.specimen import Specimen
from platform_daemon.core.schemas.base import Window
from platform_daemon.core.schemas.parameters import PAPER_NOISE_AM2_PER_S, PARAMETERS, RODRIGUES
from platform_daemon.design.equations import expected_moment, expected_omega
from platform_daemon.estimation.cramer_rao import MeasurementPlan, planned_window_s, predict_precision
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.refusal import RefusedError

from .fit_request import COEFFICIENTS
from .prediction_schema import PredictionReport, WindowPrecision


def expected_parameters(
    specimen: Specimen,
    phi_max_rad: float,
    psi_start_rad: float,
    variant: str,
    expected: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Public parameters that a fit of this specimen would find, SI: as expected, else measured, else design values.

    Raises InputError for a name that is none, and for a coefficient of the model of which nothing is known, as T_f/I of
    a jewel never measured.
    """
    possible = dict.fromkeys((*PARAMETERS, *sorted(COEFFICIENTS)))
    unknown = sorted(set(expected or {}) - set(possible))
    if unknown:
        what, remedy = f"no parameter is called {unknown[0]!r}", f"one of: {', '.join(possible)}"
        raise InputError(what, where="expected", remedy=remedy)
    m = specimen.measured
    known = {
        "f_nat_hz": expected_omega(specimen) / (2 * math.pi),
        "m_r_am2": expected_moment(specimen),
        "phi_max_rad": phi_max_rad,
        "psi_start_rad": psi_start_rad,
        **dict(zip(RODRIGUES, specimen.pose.rodrigues_rad, strict=True)),
    }
    if m.lambda_per_s is not None:
        known["lambda_per_s"] = m.lambda_per_s
    if m.tf_over_i_rad_per_s2 is not None:
        known["tf_over_i_rad_per_s2"] = m.tf_over_i_rad_per_s2
    known |= expected or {}
    coefficients = {c.name for c in model_named(variant).coefficients}
    missing = sorted(coefficients - set(known))
    if missing:
        why = "the file of this resonator has no measured value"
        remedy = f"give it: {', '.join(f'{name}=VALUE' for name in missing)}"
        raise InputError(f"{missing[0]} is not known", where=specimen.name, why=why, remedy=remedy)
    return {name: value for name, value in known.items() if name in coefficients or name not in COEFFICIENTS}


def planned_precision(
    specimen: Specimen,
    windows: Sequence[Window],
    *,
    phi_max_rad: float,
    psi_start_rad: float = 0.0,
    noise_am2_per_s: Sequence[float] = PAPER_NOISE_AM2_PER_S,
    sampling_rate_hz: float = 125e6 / 2048,
    fixed: tuple[str, ...] = (),
    variant: str | None = None,
    expected: Mapping[str, float] | None = None,
) -> PredictionReport:
    """Smallest possible standard deviations per window, of the specimen's own variant or of another model.

    Raises InputError if the plan makes no sense.
    """
    variant = variant or specimen.variant
    parameters = expected_parameters(specimen, phi_max_rad, psi_start_rad, variant, expected)
    plan = MeasurementPlan(variant, parameters, tuple(noise_am2_per_s), sampling_rate_hz, fixed)
    try:
        bounds = [(w, predict_precision(plan, planned_window_s(plan, w))) for w in windows]
    except RefusedError as refused:
        remedy = "plan a longer window or faster sampling"
        raise InputError("nothing can be predicted for this plan", why=str(refused), remedy=remedy) from None
    except (ValueError, ArithmeticError) as error:
        remedy = "give three positive noise levels, a window that ends, and a deflection below 90 deg"
        raise InputError("nothing can be predicted for this plan", why=str(error), remedy=remedy) from None
    return PredictionReport(
        variant=variant,
        expected=parameters,
        noise_sd_am2_per_s=tuple(noise_am2_per_s),
        sampling_rate_hz=sampling_rate_hz,
        windows=tuple(
            WindowPrecision(window=w, window_s=b.window_s, std=b.sd, orientation_rad=b.orientation_rad)
            for w, b in bounds
        ),
    )
