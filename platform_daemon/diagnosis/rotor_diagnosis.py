"""Diagnoses that a rotor of five degrees of freedom explains, with a manufacturing error or without one."""

from __future__ import annotations

from concurrent.futures import Executor

from .diagnosis_result import Diagnosis
from .findings.moving_parameters import moving_parameters
from .findings.rotor_findings import (
    assumed_notes,
    chi2_beside_one_angle,
    has_model_error,
    leaves_noise,
    perfect_rotor_note,
    rotor_effect,
    rotor_notes,
    rotor_scores,
    unsearched,
    worth_measuring,
)
from .findings.rotor_parting import parting
from .findings.undeclared_weight import with_weight_in_friction
from .regression.cross_validation import cross_validate
from .regression.joint_fit import JointFit
from .regression.parameters import means, window_disagreement
from .rigid_body.found_error import ManufacturingError
from .rigid_body.plane_test import PlaneTest


def of_rotor(
    base: JointFit, plane: PlaneTest, rotor: ManufacturingError, pool: Executor, *, searched: bool
) -> Diagnosis:
    """The diagnosis that a rotor of five degrees of freedom explains, without shots, defects of the data, and time."""
    if not rotor.sure:
        return _of_perfect_rotor(base, plane, rotor, pool)
    ways = parting(rotor, pool)
    parameters, weight = with_weight_in_friction(rotor.parameters, rotor.fit.shots[0].geometry)
    left = chi2_beside_one_angle(rotor, base)
    before, after = cross_validate(base, pool), rotor_scores(rotor, left)
    whole = leaves_noise(rotor) and not has_model_error(rotor) and rotor.predicts
    return Diagnosis(
        shots=(),
        refused=(),
        model=base.hypothesis.model,
        verdict="explained" if whole else "partly_explained",
        named=(rotor_effect(rotor, left, -after.worse_by(before)),),
        tentative=(),
        why_not="",
        integrity=(),
        found=unsearched(base, pool),
        final=base,
        before=before,
        after=after,
        parameters_before=means(base),
        parameters_after=parameters,
        sigma_before=window_disagreement(base, pool),
        sigma_after={},
        torque=None,
        moving=moving_parameters(base, pool),
        next_measurements=worth_measuring(ways),
        notes=(
            *assumed_notes([prepared.shot for prepared in base.prepared]),
            *rotor_notes(rotor, ways, searched=searched),
            *weight,
        ),
        seconds=0.0,
        plane=plane,
        rotor=rotor,
    )


def _of_perfect_rotor(base: JointFit, plane: PlaneTest, rotor: ManufacturingError, pool: Executor) -> Diagnosis:
    """The diagnosis that a rotor without an error explains, without shots, defects of the data, and time."""
    parameters, weight = with_weight_in_friction(rotor.parameters, rotor.fit.shots[0].geometry)
    return Diagnosis(
        shots=(),
        refused=(),
        model=base.hypothesis.model,
        verdict="nothing_missing",
        named=(),
        tentative=(),
        why_not="",
        integrity=(),
        found=unsearched(base, pool),
        final=base,
        before=cross_validate(base, pool),
        after=rotor_scores(rotor, chi2_beside_one_angle(rotor, base)),
        parameters_before=means(base),
        parameters_after=parameters,
        sigma_before=window_disagreement(base, pool),
        sigma_after={},
        torque=None,
        moving=(),
        next_measurements=(),
        notes=(
            *assumed_notes([prepared.shot for prepared in base.prepared]),
            perfect_rotor_note(rotor),
            *weight,
        ),
        seconds=0.0,
        plane=plane,
        rotor=rotor,
    )
