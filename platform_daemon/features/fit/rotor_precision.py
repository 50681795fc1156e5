"""What a planned measurement can tell of a rotor with an adopted manufacturing error, driven from rest."""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drivers.errors import InputError
from drivers.validation import validated
from platform_daemon.core.schemas.base import Window
from platform_daemon.core.schemas.parameters import RODRIGUES
from platform_daemon.core.schemas.requests import SequencePatch
from platform_daemon.core.settings import load_sequence
from platform_daemon.estimation.cramer_rao import rotor_samples
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive, LostRotorError, NoRestError, RotorValues
from platform_daemon.estimation.physics.rotation import rodrigues_from_rotation, rotation_from_rodrigues
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import RefusedError
from platform_daemon.estimation.rotor_fit.fit import RotorFit, RotorFitError, expected_fit, with_errors_of_held
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS, HELD_WITH_A_DEFECT
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from platform_daemon.estimation.screening.screening import (
    refuse_few_periods,
    refuse_few_samples,
    refuse_slow_sampling,
)
from platform_daemon.estimation.screening.windows import SampleRange, select_window
from platform_daemon.estimation.thresholds import THRESHOLDS
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.resolve import notes_of
from platform_daemon.features.models.schema import AdoptedRotorRecord
from sequences.request import SequenceRequest

from .adopted_rotor import covariance_of_adopted, reference_rotor
from .fit_with_rotor import HOLDABLE, TURNS, public_errors
from .planned_measurement import Plan
from .prediction_schema import PredictionReport, WindowPrecision
from .rotor_context import rotor_geometry

_UNDECAYED = "d30: the planned record ends before the signal has decayed to 30 %: it is used whole, as by fits"


@dataclass(frozen=True, eq=False)
class _Planned:
    """A shot at its expected values without noise; what a fit holds in it; estimate: the error is not."""

    shot: RotorShot
    error: AdoptedRotorRecord
    fixed: tuple[str, ...]
    estimate: bool

    @property
    def rx_s(self) -> float:
        """Length of the record."""
        return self.shot.samples.shape[1] / self.shot.rate_hz

    def cut_short(self, window: Window) -> bool:
        """A D30 whose record ends before the signal has decayed; fits then use the whole record, with a note."""
        return window == "d30" and bool(self._decayed.notes)

    @cached_property
    def _decayed(self) -> SampleRange:
        record = RingDownRecord(self.shot.samples, self.shot.rate_hz, "dmdt")
        return select_window(record, "d30", self.shot.values.f_nat_hz, np.zeros(3))

    def window_s(self, window: Window) -> float:
        """Raises InputError for one that is longer than the record, RefusedError for one that fits refuse."""
        shot, frequency_hz = self.shot, self.shot.values.f_nat_hz
        if window == "d30":
            seconds = self._decayed.last / shot.rate_hz
        else:
            seconds = THRESHOLDS.screening.n50_s if isinstance(window, str) else float(window)
        if round(seconds * shot.rate_hz) > shot.samples.shape[1]:
            why, remedy = (
                f"the planned record ends after {self.rx_s:.4g} s",
                "plan a longer record (--rx-s, sequence.rx_s)",
            )
            raise InputError(f"there is no window of {seconds:g} s", where="windows", why=why, remedy=remedy)
        refuse_few_samples(int(seconds * shot.rate_hz))
        refuse_few_periods(seconds, frequency_hz)
        return seconds

    def bound(self, window: Window, pool: ThreadPoolExecutor) -> WindowPrecision:
        """Raises InputError, RefusedError, RotorFitError."""
        window_s = self.window_s(window)
        found = self._fit(window_s, pool)
        names, covariance = public_errors(found)
        std = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
        if self.estimate:
            std |= {name: found.std[0][name] for name in self.own if name in found.std[0]}
        if not all(0.0 < each < math.inf for each in std.values()):
            raise RotorFitError("the window does not determine all parameters: lengthen it, or hold one")
        turned = math.hypot(*(found.std[0][name] for name in TURNS))
        return WindowPrecision(window=window, window_s=window_s, std=std, orientation_rad=turned)

    @property
    def own(self) -> tuple[str, ...]:
        """The error, and what belongs to a specimen as it does."""
        return (self.error.parameter, *HELD_WITH_A_DEFECT)

    def _fit(self, window_s: float, pool: ThreadPoolExecutor) -> RotorFit:
        if self.estimate:
            error = next(name for name in DEFECTS if name == self.error.parameter)
            return expected_fit(self.shot, error, window_s, pool, held=self.fixed)
        found = expected_fit(self.shot, None, window_s, pool, held=(*self.own, *self.fixed))
        if self.error.covariance is None:
            return found
        return with_errors_of_held(found, *covariance_of_adopted(self.error.covariance, drawn=True), pool)


def planned_rotor_precision(
    plan: Plan, model: AdoptedModel, changes: SequencePatch, *, estimate: bool
) -> PredictionReport:
    """Smallest standard deviations per window, as a fit with the model states them.

    The rotor begins at rest, and is driven by the preset's sine with these changes.  The error is held, with what
    belongs to the specimen as it does; their errors are part of the result.  estimate: all of it is estimated.

    Raises InputError if the plan makes no sense, RecordingError where the model does not tell its rotor.
    """
    assert model.rotor is not None
    table = load_sequence(plan.specimen.variant).model_dump() | changes.changes()
    values = _expected_values(plan, model)
    sequence = validated(SequenceRequest, table, "sequence")
    try:
        planned = _Planned(_shot(plan, sequence, values), model.rotor, plan.fixed, estimate)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            windows = [planned.bound(window, pool) for window in plan.windows]
    except (RotorFitError, NoRestError, LostRotorError, RefusedError) as error:
        remedy = "plan another window, a weaker field or faster sampling"
        raise InputError("nothing can be predicted for this plan", why=str(error), remedy=remedy) from None
    names = [name for name in HOLDABLE if name in windows[0].std or name in plan.fixed]
    rodrigues = rodrigues_from_rotation(values.rotation).tolist()
    expected = {name: getattr(values, name) for name in (*names, model.rotor.parameter)}
    expected |= {name: getattr(values, name) for name in windows[0].std if name in HELD_WITH_A_DEFECT}
    errors = "without" if model.rotor.covariance is None else "with"
    said = "all of the rotor is estimated" if estimate else f"errors are {errors} those of what is held"
    swing = math.degrees(_deflection_rad(planned.shot))
    return plan.report(
        model.label,
        expected | dict(zip(RODRIGUES, rodrigues, strict=True)),
        windows,
        (
            *notes_of(model),
            f"from rest by {1e6 * sequence.field_t:.4g} uT along {sequence.axis}, {sequence.tx_periods} periods of "
            f"{sequence.f_tx_hz:.6g} Hz, to a deflection of {swing:.3g} deg; {said}",
            *([_UNDECAYED] if any(planned.cut_short(window) for window in plan.windows) else []),
        ),
    )


def _expected_values(plan: Plan, model: AdoptedModel) -> RotorValues:
    """As expected, else as diagnosed.  Raises InputError for a name that is none of the rotor's, RecordingError."""
    assert model.rotor is not None
    specimen, expected = plan.specimen, plan.expected
    own = HOLDABLE if specimen.variant == "jewel" else HOLDABLE[:-1]
    for given, names, where in ((plan.fixed, own, "fixed"), (expected, (*own, *RODRIGUES), "expected")):
        unknown = sorted({*given} - {*names})
        if unknown:
            what, remedy = f"{model.label} has no {unknown[0]!r} here", f"one of: {', '.join(names)}"
            raise InputError(what, where=where, remedy=remedy)
    pose = dict(zip(RODRIGUES, specimen.pose.rodrigues_rad, strict=True)) | dict(expected)
    rotation = rotation_from_rodrigues(np.array([pose[name] for name in RODRIGUES]))
    numbers = {name: value for name, value in expected.items() if name in own}
    for name, value in numbers.items():
        if not value > 0.0:
            raise InputError(f"{name} = {value:g} makes no sense", where="expected", remedy="give a positive value")
    return reference_rotor(model, specimen, rotation).with_numbers(numbers)


def _shot(plan: Plan, sequence: SequenceRequest, values: RotorValues) -> RotorShot:
    """Without noise, at no more samples a period than matter.

    Raises InputError, RefusedError, NoRestError, LostRotorError.
    """
    if not sequence.is_plain:
        why, remedy = (
            "its motion is followed through a sine of one frequency",
            "leave waveform, chirp and phase_plan out",
        )
        raise InputError("this drive cannot be planned here", where="sequence", why=why, remedy=remedy)
    refuse_slow_sampling(plan.sampling_rate_hz, values.f_nat_hz)
    try:
        samples, rate_hz = rotor_samples(sequence.rx_s, plan.sampling_rate_hz, values.f_nat_hz)
    except ValueError as error:
        what, remedy = "the planned record is too long", "shorten it (--rx-s, sequence.rx_s)"
        raise InputError(what, where="sequence.rx_s", why=str(error), remedy=remedy) from None
    x, y, z = (sequence.field_t * sequence.direction()).tolist()
    tx_s = sequence.tx_periods / sequence.f_tx_hz
    drive = CoilDrive(
        field_t=(x, y, z),
        frequency_hz=sequence.f_tx_hz,
        phase_rad=sequence.phase_rad,
        duration_s=tx_s,
        rx_start_s=tx_s + sequence.switch_s,
    )
    shot = RotorShot(
        samples=np.zeros((3, samples)),
        rate_hz=rate_hz,
        sd=np.array(plan.noise_am2_per_s) * math.sqrt(rate_hz / plan.sampling_rate_hz),
        geometry=rotor_geometry(plan.specimen),
        drive=drive,
        values=values,
        declared=values.rotation,
    )
    shot.samples[:] = shot.rotor(values).dm_dt(samples, rate_hz)[0]
    return shot


def _deflection_rad(shot: RotorShot) -> float:
    """Of the main mode: on an undamped orbit the largest dm/dt along v is 2 m_r w sin(A/2)."""
    values = shot.values
    peak = float(np.max(np.abs(values.rotation[:, 1] @ shot.samples)))
    return 2.0 * math.asin(min(1.0, peak / (4.0 * math.pi * values.m_r_am2 * values.f_nat_hz)))
