"""What a diagnosis found, from which reports are made."""

from __future__ import annotations

from dataclasses import dataclass

from platform_daemon.estimation.physics.models import RingDownModel

from .findings.accepted_effects import AcceptedEffect
from .findings.missing_torque import MissingTorque
from .findings.moving_parameters import MovingParameter
from .findings.next_measurements import Proposal
from .regression.cross_validation import CrossValidation
from .regression.joint_fit import JointFit
from .regression.parameters import Mean
from .report_schema import DiagnosisVerdict
from .rigid_body.found_error import ManufacturingError
from .rigid_body.plane_test import PlaneTest
from .selection.data_integrity import DataDefect
from .selection.stepwise import Selection
from .shots.initial_fits import UnfittedShot
from .shots.shot import DiagnosisShot


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """The result of a diagnosis, from which reports are made.

    Attributes:
        shots: all shots. refused: those without a fit. model: the declared model. verdict: as in the report.
        named: accepted effects. tentative: effects that gain but were not accepted; why_not: the reason, a sentence.
        integrity: defects of the files and of the data.
        found: the end of the search. final: the joint fit after validation.
        before, after: held-out scores with the declared model and with the final one.
        parameters_before, parameters_after: means by public name, SI; sigma_before, sigma_after: |N50 - D30| over its
            standard error.
        plane: whether the motion leaves the plane of one angle; None: what was recorded does not tell. rotor: the
            manufacturing error that explains that it does, or the rotor without one (`rotor.sure`); `named`, `verdict`,
            `after` and `parameters_after` are then about it, and `final` is the declared model alone.
        torque: map of the missing torque. moving: parameters that are not constant. notes: sentences for the reader.
        seconds: wall time of the diagnosis, s.
    """

    shots: tuple[DiagnosisShot, ...]
    refused: tuple[UnfittedShot, ...]
    model: RingDownModel
    verdict: DiagnosisVerdict
    named: tuple[AcceptedEffect, ...]
    tentative: tuple[AcceptedEffect, ...]
    why_not: str
    integrity: tuple[DataDefect, ...]
    found: Selection
    final: JointFit
    before: CrossValidation
    after: CrossValidation
    parameters_before: dict[str, Mean]
    parameters_after: dict[str, Mean]
    sigma_before: dict[str, float]
    sigma_after: dict[str, float]
    torque: MissingTorque | None
    moving: tuple[MovingParameter, ...]
    next_measurements: tuple[Proposal, ...]
    notes: tuple[str, ...]
    seconds: float
    plane: PlaneTest | None = None
    rotor: ManufacturingError | None = None

    @property
    def tentative_after(self) -> tuple[AcceptedEffect, ...]:
        """The tentative effects that are part of the final model."""
        keys = {c.key for c in self.final.hypothesis.effects}
        return tuple(n for n in self.tentative if n.candidate.key in keys)
