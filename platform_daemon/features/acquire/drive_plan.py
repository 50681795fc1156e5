"""A drive in phase with the velocity: from what is known of a resonator to the half periods of the field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.errors import SequenceRejected
from drivers.specimen import Specimen
from platform_daemon.design.equations import expected_inertia, expected_moment, expected_omega
from sequences.lobes import Lobes
from sequences.request import SequenceRequest

if TYPE_CHECKING:
    from platform_daemon.estimation.physics.models import RingDownModel
    from platform_daemon.features.fit.online import NamedModel
    from platform_daemon.features.models.resolve import ModelChoice

_ALWAYS = ("f_nat_hz", "m_r_am2")


@dataclass(frozen=True)
class DrivePlan:
    """Half periods of the field, and the deflection that the model reaches under them, rad."""

    lobes: Lobes
    phi_max_rad: float


@dataclass(frozen=True)
class DriveTask:
    """See plan_drive.  A task of the task executor."""

    sequence: SequenceRequest
    tx_s: float
    specimen: Specimen
    model: NamedModel
    lag_s: float
    fitted: Mapping[str, float] | None = None

    def __call__(self, tell: Callable[[float, str], None]) -> DrivePlan:
        """Raises SequenceRejected."""
        return plan_drive(self.sequence, self.tx_s, self.specimen, self.model.choice(), self.lag_s, self.fitted)


def plan_drive(
    sequence: SequenceRequest,
    tx_s: float,
    specimen: Specimen,
    choice: ModelChoice,
    lag_s: float,
    fitted: Mapping[str, float] | None = None,
) -> DrivePlan:
    """The field that follows the velocity of the model from rest, for `tx_s` of TX.

    Its values are those of the specimen, in their place `plan_parameters`, in their place those of a fit (`fitted`, by
    public name).  lag_s: L/R of the loop that makes the field.  Raises SequenceRejected: a value that the model has
    not, or no oscillation with these.
    """
    from platform_daemon.estimation.physics.driven import DrivenModel, NoPlanError, plan_for_all
    from platform_daemon.estimation.physics.models import model_named
    from platform_daemon.features.models.adopted_model import AdoptedModel

    model = choice.model if isinstance(choice, AdoptedModel) else model_named(choice)
    known = _known(sequence, specimen, model) | {n: v for n, v in (fitted or {}).items() if n in _names(model)}
    direction = _rotation(specimen, fitted).T @ sequence.direction()
    per_tesla = known["m_r_am2"] / expected_inertia(specimen)
    u, v, _ = (per_tesla * sequence.field_t * direction).tolist()
    driven = DrivenModel(
        model,
        2 * np.pi * known["f_nat_hz"],
        tuple(known[c.name] for c in model.coefficients),
        (v, u),
        sequence.duty if sequence.waveform == "rectangle" else None,
        lag_s,
    )
    try:
        plan = plan_for_all(driven, tx_s, sequence.f_nat_tolerance)
    except NoPlanError as error:
        raise SequenceRejected(
            "no drive can be planned that follows the rotor",
            where="sequence.phase_plan",
            why=str(error),
            remedy="check sequence.axis, field_t and tx_periods against the resonator's file, or plan_parameters",
        ) from None
    lobes = Lobes(plan.zeros_s, plan.first_sign, sequence.waveform, sequence.duty).until(tx_s)
    return DrivePlan(lobes, driven.reached_rad(lobes.zeros_s, lobes.first_sign))


def _names(model: RingDownModel) -> tuple[str, ...]:
    return (*_ALWAYS, *(c.name for c in model.coefficients))


def _known(sequence: SequenceRequest, specimen: Specimen, model: RingDownModel) -> dict[str, float]:
    """Every value of the model.  Raises SequenceRejected for a parameter that it has not, or that cannot be."""
    omega, measured = expected_omega(specimen), specimen.measured
    known = {c.name: c.typical * omega**c.power if c.hidden else 0.0 for c in model.coefficients}
    known |= {n: p.fixed for n, p in model.parameters.items() if n in known and p.fixed is not None}
    own = {"lambda_per_s": measured.lambda_per_s or 0.0, "tf_over_i_rad_per_s2": measured.tf_over_i_rad_per_s2 or 0.0}
    known |= {name: value for name, value in own.items() if name in known}
    known |= {"f_nat_hz": omega / (2 * np.pi), "m_r_am2": expected_moment(specimen)}
    for name, value in sequence.plan_parameters.items():
        where, names = f"sequence.plan_parameters.{name}", _names(model)
        if name not in names:
            remedy = f"one of: {', '.join(names)}"
            raise SequenceRejected(f"the model {model.name} has no {name}", where=where, remedy=remedy)
        if value <= 0 and name in _ALWAYS:
            raise SequenceRejected(f"{name} cannot be {value:g}", where=where, remedy="give a value above 0")
    return known | dict(sequence.plan_parameters)


def _rotation(specimen: Specimen, fitted: Mapping[str, float] | None) -> NDArray[np.float64]:
    """e_u, e_v, e_w in world axes as columns: as fitted, else as the specimen is mounted."""
    from platform_daemon.estimation.parameters import RODRIGUES
    from platform_daemon.estimation.physics.mirror import rotations

    vector = specimen.pose.rodrigues_rad
    if fitted is not None and all(name in fitted for name in RODRIGUES):
        vector = tuple(fitted[name] for name in RODRIGUES)  # type: ignore[assignment]
    return np.asarray(rotations(np.array(vector, dtype=float)).as_matrix())
