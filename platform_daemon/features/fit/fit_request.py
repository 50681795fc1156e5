"""The request of a fit: model, window, held parameters; checked before any work begins."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError
from platform_daemon.core.schemas.base import Window
from platform_daemon.core.schemas.fits import FrameFit
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.torques import TERMS
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.resolve import ModelChoice, label_of, model_of

NAME_THE_VARIANT = "name the variant, thread or jewel (--variant, or `variant` of a request)"
NAMED_WINDOWS: dict[str, Window] = {"n50": "n50", "d30": "d30"}
COEFFICIENTS = frozenset(c.name for term in TERMS.values() for c in term.coefficients)


class FitRefused(InputError):
    """A fit that everything else rests on was refused."""

    title = "Fit refused"


@dataclass(frozen=True, eq=False)
class FitSettings:
    """How to fit any file.

    Attributes:
        model: a declared or an adopted one; None: what each file says.  terms: further torque terms.
        window: "n50", "d30" or seconds.
        fixed, hold_if_inseparable: parameters held, by name: always, or where the window cannot tell them.
        calibration: replaces the files' own; with where it came from.  None: the files' own.
        derived: give derived quantities too.
        frames: of every file; None: all of the step.
        step: of a procedure's recording, number or name; None: the last one; ALL_STEPS: every frame.
    """

    model: ModelChoice | None = None
    window: Window = "d30"
    fixed: dict[str, float] | None = None
    calibration: tuple[ReceiveCalibration, str] | None = None
    derived: bool = False
    hold_if_inseparable: dict[str, float] | None = None
    terms: tuple[str, ...] = ()
    frames: tuple[int, ...] | None = None
    step: str | None = None


@dataclass(frozen=True)
class FitRequest:
    """How to fit.

    Attributes:
        model: a declared one, with further torque terms after "+" if there are any; or an adopted one.
        window: "n50", "d30" or seconds.
        fixed: parameters held, by name.
        hold_if_inseparable: losses held only in frames whose window cannot tell them apart.
        moment_am2: what is known of the resonator's moment, A m^2; a fit that disagrees is warned of.
        weight_over_pull: of a jewel's rotor, see `known_weight`.
    """

    model: ModelChoice
    window: Window = "d30"
    fixed: Mapping[str, float] | None = None
    hold_if_inseparable: Mapping[str, float] | None = None
    moment_am2: float | None = None
    weight_over_pull: float = 0.0

    @property
    def ring_down_model(self) -> RingDownModel:
        """What is fitted."""
        return model_of(self.model).under_weight(self.weight_over_pull)

    @property
    def of_rotor(self) -> bool:
        """The model holds a manufacturing error: fits take a rotor of five degrees of freedom."""
        return isinstance(self.model, AdoptedModel) and self.model.rotor is not None

    @property
    def one_angle(self) -> FitRequest:
        """The same without a manufacturing error: where the fit of a rotor starts, and whose parameters it has."""
        model = self.model
        return replace(self, model=model.one_angle) if isinstance(model, AdoptedModel) and model.rotor else self

    @property
    def label(self) -> str:
        """What results are marked with: the declared name, or NAME@VERSION."""
        return label_of(self.model)


def check_fixed(ask: FitRequest, *, calibrated: bool) -> None:
    """Raises InputError for a parameter that cannot be held or hinted at, or not at that value."""
    model = ask.one_angle.ring_down_model
    allowed = ["f_nat_hz", *(c.name for c in model.coefficients), *(["m_r_am2"] if calibrated else [])]
    for name, value in (ask.fixed or {}).items():
        if name not in allowed:
            why = f"a {ask.label} {'with' if calibrated else 'without'} calibration lets hold {', '.join(allowed)}"
            raise InputError(f"{name!r} cannot be held fixed", where="fixed", why=why, remedy="leave it free")
        _check_value(model, name, value, "fixed")
    for name, value in (ask.hold_if_inseparable or {}).items():
        if name not in model.losses:
            why = f"the losses of a {ask.label} are {', '.join(model.losses)}"
            raise InputError(f"no hint can be given for {name!r}", where="hints", why=why, remedy="leave it out")
        _check_value(model, name, value, "hints")


def _check_value(model: RingDownModel, name: str, value: float, where: str) -> None:
    """Raises InputError for a value that no resonator can have."""
    signed = name in {c.name for c in model.coefficients} - set(model.losses)
    possible = signed or value > 0 or (value == 0 and name in model.losses)
    limits = model.parameters[name]
    if not (math.isfinite(value) and possible and limits.lower <= value <= limits.upper):
        remedy = "give a finite value" if signed else "give a finite positive value"
        raise InputError(f"{name} = {value} makes no sense", where=where, remedy=remedy)


def without_fit(frames: Sequence[FrameFit]) -> tuple[str, str] | None:
    """What is wrong with frames none of which has a fit, and why, each reason once; None if one of them has a fit."""
    if any(frame.good for frame in frames):
        return None
    excited = [frame for frame in frames if not frame.blank]
    reasons: dict[str, list[int]] = {}
    for frame in excited or frames:
        reasons.setdefault(frame.reason or "", []).append(frame.frame)
    why = "; ".join(f"frame {', '.join(map(str, k))}: {reason}" for reason, k in reasons.items())
    if not excited:
        return "no frame was excited", why
    return "every frame was refused" if len(excited) == len(frames) else "every excited frame was refused", why
