"""The rotor of five degrees of freedom that an adopted manufacturing error belongs to."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drivers.errors import RecordingError
from drivers.specimen import Specimen
from platform_daemon.core.schemas.fits import Covariance
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.rotor_fit.parameters import OFF_DRAWING
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.schema import AdoptedRotorRecord


def adopted_values(
    error: AdoptedRotorRecord, main: Mapping[str, float], rotation: Array, *, drawn: bool
) -> RotorValues:
    """The rotor with an error and what belongs to it.

    main: f_nat, m_r, lambda and T_f/I by public name; drawn: the resonator's own drawing is known, so that nothing is
    made of how far it was off the one of the shipped resonator.
    """
    held = {name: value for name, value in error.held.items() if not drawn or name not in OFF_DRAWING}
    return RotorValues(
        f_nat_hz=main["f_nat_hz"],
        m_r_am2=main["m_r_am2"],
        lambda_per_s=main["lambda_per_s"],
        tf_over_i_rad_per_s2=main.get("tf_over_i_rad_per_s2", 0.0),
        rotation=rotation,
        **({"lean_damping_per_s": held["side_damping_per_s"]} | held),  # one damping in models of before
    ).with_numbers({error.parameter: error.strength})


def reference_rotor(model: AdoptedModel, specimen: Specimen, rotation: Array) -> RotorValues:
    """The rotor that a model with a manufacturing error was adopted from, in this pose, (3, 3).

    Raises RecordingError where its diagnosis does not tell a number.
    """
    assert model.rotor is not None
    found = model.diagnosed
    friction = specimen.measured.tf_over_i_rad_per_s2 or found.get("tf_over_i_rad_per_s2")
    missing = [name for name in ("f_nat_hz", "m_r_am2", "lambda_per_s") if name not in found]
    missing += ["tf_over_i_rad_per_s2"] if specimen.variant == "jewel" and friction is None else []
    if missing:
        why = f"the model's diagnosis does not tell {missing[0]}"
        remedy = "diagnose and adopt again"
        raise RecordingError(f"{model.label} cannot be used here", where="variant", why=why, remedy=remedy)
    main = found | {"tf_over_i_rad_per_s2": (friction or 0.0) if specimen.variant == "jewel" else 0.0}
    return adopted_values(model.rotor, main, rotation, drawn=True)


def covariance_of_adopted(known: Covariance, *, drawn: bool) -> tuple[tuple[str, ...], Array]:
    """Names and matrix; in models of before one damping of the side modes stands for both.  drawn: as above."""
    names, matrix = tuple(known.parameters), np.array(known.matrix)
    if "side_damping_per_s" in names and "lean_damping_per_s" not in names:
        rows = [*range(len(names)), names.index("side_damping_per_s")]
        names, matrix = (*names, "lean_damping_per_s"), matrix[np.ix_(rows, rows)]
    kept = [k for k, name in enumerate(names) if not drawn or name not in OFF_DRAWING]
    return tuple(names[k] for k in kept), matrix[np.ix_(kept, kept)]
