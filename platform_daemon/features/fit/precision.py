"""What a planned measurement can tell: the Cramer-Rao bound for a resonator, a deflection, a noise and windows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from drivers.errors import InputError
from drivers.specimen import Specimen
from platform_daemon.core.schemas.base import Window
from platform_daemon.core.schemas.parameters import (
    PAPER_DEFLECTION_DEG,
    PAPER_NOISE_AM2_PER_S,
    PARAMETERS,
    RODRIGUES,
)
from platform_daemon.core.schemas.requests import SequencePatch
from platform_daemon.design.equations import expected_moment, expected_omega
from platform_daemon.estimation.cramer_rao import MeasurementPlan, planned_window_s, predict_precision
from platform_daemon.estimation.refusal import RefusedError
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.library import Library
from platform_daemon.features.models.resolve import ModelChoice, label_of, model_of, notes_of, resolve, with_terms

from .fit_request import COEFFICIENTS
from .planned_measurement import Plan
from .prediction_schema import PredictionReport, WindowPrecision
from .rotor_context import BEARINGS
from .rotor_precision import planned_rotor_precision

_RECEIVER = "the noise is that of dm/dt after the receiver's effects are undone"


def planned_model(
    variant: str | None, terms: Sequence[str], library: Library | None, specimen: Specimen
) -> ModelChoice:
    """What is to be fitted, declared or adopted; None: the specimen's own variant.

    Raises InputError for a name that is none, further terms of an adopted model, and one of the other bearing.
    """
    found = with_terms(resolve(variant, library) or specimen.variant, terms)
    if isinstance(found, AdoptedModel) and found.base in BEARINGS and found.base != specimen.variant:
        why = f"{specimen.name!r} has a {specimen.variant} bearing"
        remedy = "name a model of this resonator (platform-daemon models), or another resonator"
        raise InputError(f"{found.label} was adopted from a {found.base}", where="variant", why=why, remedy=remedy)
    return found


_CONSTANT = ("f_nat_hz", "m_r_am2", "lambda_per_s")


def expected_parameters(
    specimen: Specimen,
    phi_max_rad: float,
    psi_start_rad: float,
    choice: ModelChoice,
    expected: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Public parameters that a fit of this specimen would find, SI: as expected, else measured, else design values.

    An adopted model has its own strengths, and the f_nat, m_r and lambda of its diagnosis.  T_f/I, which differs from
    shot to shot, is that of the specimen's file if it has one.

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
    model = model_of(choice)
    if isinstance(choice, AdoptedModel):
        told = {n: v for n, v in choice.diagnosed.items() if n in (*_CONSTANT, "tf_over_i_rad_per_s2")}
        known = told | known | {n: v for n, v in told.items() if n in _CONSTANT}
        known |= {name: value for term in choice.terms for name, value in term.values.items()}
    known |= {p.name: p.fixed for p in model.parameters.values() if p.fixed is not None} | dict(expected or {})
    coefficients = {c.name for c in model.coefficients}
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
    phi_max_rad: float | None = None,
    psi_start_rad: float = 0.0,
    noise_am2_per_s: Sequence[float] = PAPER_NOISE_AM2_PER_S,
    sampling_rate_hz: float = 125e6 / 2048,
    fixed: tuple[str, ...] = (),
    model: ModelChoice | None = None,
    estimate_adopted: bool = False,
    expected: Mapping[str, float] | None = None,
    sequence: SequencePatch = SequencePatch(),  # noqa: B008 frozen
) -> PredictionReport:
    """Smallest possible standard deviations per window.

    Args:
        phi_max_rad: None: the paper's; psi_start_rad: at the first sample.
        model: that is to be fitted, None: the specimen's own variant.
        estimate_adopted: strengths that an adopted model holds are estimated, hidden scales as a time constant stay
            held; False: all are held, as by fits.
        expected: values in the place of the specimen's, by public name.
        sequence: of a model with a manufacturing error, whose motion begins with the drive: keys that differ from the
            preset; the other arguments are as in the request of a prediction.

    Raises InputError, RecordingError if the plan makes no sense.
    """
    chosen = specimen.variant if model is None else model
    if len(noise_am2_per_s) != 3 or not all(0.0 < level < math.inf for level in noise_am2_per_s):
        why = f"they are {', '.join(f'{level:g}' for level in noise_am2_per_s)}"
        raise InputError(
            "the noise levels make no sense", where="noise", why=why, remedy="give three positive ones, A m^2/s"
        )
    if not windows:
        raise InputError("no window is planned", where="windows", remedy="give n50, d30 or seconds")
    plan = Plan(specimen, windows, tuple(noise_am2_per_s), sampling_rate_hz, fixed, expected or {})
    if isinstance(chosen, AdoptedModel) and chosen.rotor is not None:
        if phi_max_rad is not None:
            why, remedy = "the drive decides how far the rotor swings", "give the field (--field-ut, sequence.field_t)"
            raise InputError("a deflection cannot be planned here", where="phi_max_rad", why=why, remedy=remedy)
        return planned_rotor_precision(plan, chosen, sequence, estimate=estimate_adopted)
    if sequence.changes():
        why = f"a {label_of(chosen)} begins with its largest deflection, whatever made it"
        remedy = "give the deflection (--deflection-deg, phi_max_rad), or a model with a manufacturing error"
        raise InputError("a drive cannot be planned here", where="sequence", why=why, remedy=remedy)
    return _planned(plan, _with_free(chosen) if estimate_adopted else chosen, phi_max_rad, psi_start_rad)


def _with_free(chosen: ModelChoice) -> AdoptedModel:
    """The model with its strengths free.  Raises InputError if it holds none."""
    if not isinstance(chosen, AdoptedModel) or all(term.free for term in chosen.terms):
        why = f"{label_of(chosen)} holds no strength of a torque and no manufacturing error"
        what, remedy = "there is nothing adopted to estimate", "leave estimate_adopted out"
        raise InputError(what, where="estimate_adopted", why=why, remedy=remedy)
    return replace(chosen, terms=tuple(term.model_copy(update={"free": True}) for term in chosen.terms))


def _planned(planned: Plan, chosen: ModelChoice, phi_max_rad: float | None, psi_start_rad: float) -> PredictionReport:
    """Of a model of one angle.  Raises InputError."""
    specimen = planned.specimen
    deflection = math.radians(PAPER_DEFLECTION_DEG[specimen.variant]) if phi_max_rad is None else phi_max_rad
    parameters = expected_parameters(specimen, deflection, psi_start_rad, chosen, planned.expected)
    plan = MeasurementPlan(
        model_of(chosen), parameters, planned.noise_am2_per_s, planned.sampling_rate_hz, planned.fixed
    )
    try:
        bounds = [(w, predict_precision(plan, planned_window_s(plan, w))) for w in planned.windows]
    except RefusedError as refused:
        remedy = "plan a longer window or faster sampling"
        raise InputError("nothing can be predicted for this plan", why=str(refused), remedy=remedy) from None
    except (ValueError, ArithmeticError) as error:
        remedy = "give three positive noise levels, a window that ends, and a deflection below 90 deg"
        raise InputError("nothing can be predicted for this plan", why=str(error), remedy=remedy) from None
    undone = isinstance(chosen, AdoptedModel) and chosen.receiver
    return planned.report(
        label_of(chosen),
        parameters,
        [
            WindowPrecision(window=w, window_s=b.window_s, std=b.sd, orientation_rad=b.orientation_rad)
            for w, b in bounds
        ],
        (*notes_of(chosen), *([_RECEIVER] if undone else [])),
    )
