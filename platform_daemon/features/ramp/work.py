"""Ramp: the field is raised until side modes show in the z channel, never where they are too likely to (paper,
"Measurement Sequence")."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .predicted import PredictedThreshold
    from .z_residual import SideLine, ZResidual

from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

from drivers.errors import DeviceFault, InputError, PlatformError, SequenceRejected
from drivers.specimen import Specimen
from platform_daemon.core.schemas.requests import AcquisitionRequest, SequencePatch
from platform_daemon.core.schemas.sweep_axis import MOST_STEPS
from platform_daemon.core.schemas.value_sources import PROCEDURE, Origin
from platform_daemon.features.fit.online import NamedModel
from platform_daemon.features.procedures.bench import ProcedureBench
from platform_daemon.features.procedures.conductor import ProcedureWork
from platform_daemon.features.procedures.procedure import ShotFiles, Step, StepSequence
from platform_daemon.features.procedures.schema import ProcedureResult, StepReport, SweptValue
from sequences.request import SequenceRequest

from .computed_side_modes import ComputedSideModes, model_with_error
from .resonator_limits import Keep, save_to_catalogue, save_with_recording
from .schema import (
    RampBound,
    RampChance,
    RampLine,
    RampNextField,
    RampOutcome,
    RampPrediction,
    RampRequest,
    RampStep,
    RampThreshold,
)

OPERATING_SHARE = 0.8
"""Of the threshold, at which a resonator is to be used (paper, "Measurement Sequence")."""
_START_SHARE = 0.5  # of the preset's field
_LONGEST_RX_S = 2.0  # side modes have decayed by then
_NEVER_RINGS = 3  # shots
_LEARN = 3  # blank shots, in which the noise is measured: side modes begin far below where they are seen
_MULTIPLES: tuple[tuple[int, Literal["f", "2f", "3f"]], ...] = ((1, "f"), (2, "2f"), (3, "3f"))
_NEAR = 0.03  # relative, of a multiple of the main mode
_SATURATED = 0.5  # growth of the deflection over that of the field


class NeverRings(PlatformError):
    """A resonator that no shot has set in motion."""

    title = "Nothing rings"


class SideModes(Protocol):
    """Who looks at the z channel: today this process, later one of its own."""

    def learn(self, blank: Sequence[Path]) -> None:
        """The noise, from shots without excitation.  Raises RecordingError."""

    def of(self, shots: Sequence[Path]) -> list[ZResidual]:
        """What recorded shots show out of the plane.  Raises RecordingError."""

    def predicted(
        self, model: NamedModel, shot: Path, main_hz: float | None, lowest_t: float, highest_t: float
    ) -> PredictedThreshold:
        """The threshold by a model with a manufacturing error.  Raises RecordingError."""


@dataclass(frozen=True)
class RampBasis:
    """What a ramp starts from.

    Attributes:
        sequence: of the resonator.
        limit_t, bound: highest field allowed, T, and by what: the platform, or an earlier ramp unless it may go beyond
            that.
        period_s: of listening and pause in the preset, which lets the rotor rest.
        check: whether a step can be made; raises SequenceRejected outside the safety envelope.
        model: with a manufacturing error, whose threshold is predicted; None: no one's.
    """

    sequence: SequenceRequest
    limit_t: float
    bound: RampBound
    period_s: float
    check: Callable[[AcquisitionRequest], object]
    model: NamedModel | None = None


class Ramp:
    """See Procedure.  Raises InputError for fields that cannot be."""

    def __init__(self, request: RampRequest, basis: RampBasis, keep: Keep, looks: SideModes) -> None:
        from .escalation import Escalation, RampPlan

        start = request.start_t or round(_START_SHARE * basis.sequence.field_t / request.step_t) * request.step_t
        most = request.max_t or basis.limit_t
        if most > basis.limit_t:
            what = f"{1e6 * most:.6g} uT lies above the limit, {1e6 * basis.limit_t:.6g} uT"
            raise InputError(
                what,
                where="max_t",
                remedy="lower it: it is limits.max_field_t, or what an earlier ramp has kept (beyond_side_modes)",
            )
        if not 0.0 < start <= most:
            what = f"the first field, {1e6 * start:.6g} uT, does not lie between 0 and {1e6 * most:.6g} uT"
            raise InputError(what, where="start_t", remedy="give start_t below max_t")
        if (most - start) / request.step_t > MOST_STEPS:
            what = f"more than {MOST_STEPS} steps lie between {1e6 * start:.6g} and {1e6 * most:.6g} uT"
            raise InputError(what, where="step_t", remedy="make the steps larger, or the span smaller")
        self.request = request
        self._f_tx_hz = basis.sequence.f_tx_hz
        self._rx_s = min(basis.sequence.rx_s, _LONGEST_RX_S)
        # The rotor is to be at rest again: what a shot no longer listens to, it waits.
        self._pause_s = max(0.0, basis.period_s - self._rx_s)
        self._given = request.acquisition.sequence.changes()
        self._tuned: tuple[str, ...] = ()
        self._known = False  # the noise
        bound: RampBound = "requested_limit"
        if request.max_t is None:
            most, bound = self._highest_possible(basis, start)
        self._plan = RampPlan(
            start, request.step_t, most, request.overdose_rate, request.false_stop_rate, request.most_shots, bound
        )
        self._state = Escalation(self._plan)
        self._keep, self._kept = keep, ""
        self._looks = looks
        self._files: ShotFiles | None = None
        self._unseen: list[Path] = []  # shots at the first field, made before it
        self._angles: dict[float, list[float]] = {}
        self._main_hz: float | None = None
        self._ended = False
        self._model = basis.model
        self._shot: Path | None = None
        self._prediction: RampPrediction | None = None

    @property
    def title(self) -> str:
        """See Procedure."""
        return f"ramp from {1e6 * self._plan.start_t:.4g} uT"

    @property
    def ends_early(self) -> str:
        """See Procedure."""
        return "side modes show, or the next step would be too likely to lie above their threshold"

    @property
    def open_ended(self) -> bool:
        """See Procedure."""
        return True

    def tuned(self, keys: Mapping[str, Any]) -> None:
        """Use these keys of a sequence from now on, except where the request gives its own."""
        found = {k: v for k, v in keys.items() if k not in ("field_t", "rx_s", "pause_s") and k not in self._given}
        self._given |= found
        self._tuned = tuple(found)

    def reads(self, files: ShotFiles) -> None:
        """See ReadsShots."""
        self._files = files

    def outline(self) -> Sequence[Step]:
        """See Procedure."""
        fields, at = [], self._plan.start_t
        while at < self._plan.max_t * (1.0 - 1e-9):
            fields.append(at)
            at += self._plan.step_t
        first = [self._step(self._plan.start_t, 0), self._step(self._plan.start_t, _LEARN)]
        return [*first, *(self._step(f, 0) for f in [*fields[1:], self._plan.max_t])]

    def _highest_possible(self, basis: RampBasis, start_t: float) -> tuple[float, RampBound]:
        """The limit, T, or the highest step below it that coils and amplifier allow; and which of them it is."""

        def refused(field_t: float) -> bool:
            try:
                basis.check(self._step(field_t, 0).acquisition)
            except SequenceRejected:
                return True
            return False

        if not refused(basis.limit_t) or refused(start_t):  # a first field that is refused is refused with its reason
            return basis.limit_t, basis.bound
        step_t = self.request.step_t
        fields = [start_t + k * step_t for k in range(int((basis.limit_t - start_t) / step_t) + 1)]
        return fields[bisect_left(fields, True, key=refused) - 1], "envelope"

    def _step(self, field_t: float, blank: int) -> Step:
        sequence = self._given | {"field_t": field_t}
        sequence |= {k: v for k, v in (("rx_s", self._rx_s), ("pause_s", self._pause_s)) if k not in self._given}
        tables = self.request.acquisition.model_dump(exclude_none=True) | {
            "sequence": sequence, "shots": 1, "blank_shots": blank,
        }  # fmt: skip
        made = AcquisitionRequest.model_validate(tables)
        # Until something rings a shot is listened to: what moves in many ways at once is not fitted, but rings.
        near_hz = None if self._known else sequence.get("f_tx_hz", self._f_tx_hz)
        origins = dict.fromkeys(self._tuned, Origin("tuned")) | {
            k: PROCEDURE for k in ("field_t", "rx_s", "pause_s") if k == "field_t" or k not in self._given
        }
        return Step((SweptValue(key="field_ut", value=round(1e6 * field_t, 6)),), made, near_hz, origins, "ramp")

    def steps(self) -> StepSequence:
        """See Procedure.  Raises NeverRings, RecordingError; DeviceFault for a receiver that saturates."""
        assert self._files is not None
        looked = silent = unusable = 0
        while (field_t := self._state.next_field()) is not None:
            # Blank shots only once something rings, which saves their time elsewhere.
            report = yield self._step(field_t, _LEARN if looked and not self._known else 0)
            self._see(field_t, report)
            rings = report.fitted > 0 or report.heard is not None
            looked += rings
            silent = 0 if rings else silent + 1
            usable = not self._known or any(map(self._files.usable, report.frames))
            unusable = 0 if usable else unusable + 1
            if not looked and silent >= _NEVER_RINGS:
                raise NeverRings(
                    f"no ring-down in {silent} shots",
                    where=f"{1e6 * field_t:.4g} uT along {self.request.acquisition.sequence.axis or 'the preset axis'}",
                    why=report.reason or "",
                    remedy="check that the resonator is mounted, its f_tx_hz and the axis; or start at a higher field",
                )
            if unusable >= _NEVER_RINGS:  # else a field whose shots are all refused would be repeated for ever
                raise NeverRings(
                    f"{unusable} shots in a row were refused",
                    where=f"{1e6 * field_t:.4g} uT",
                    why=report.reason or "",
                    remedy="remove what the reason names, then ramp again",
                )
        self._ended = True
        self._prediction = self._predicted()
        saturated = "; the drive is saturated: a higher field hardly swings it further" if self._saturated() else ""
        return self._state.why_ended() + (saturated if self._state.threshold_t() is None else "")

    def _predicted(self) -> RampPrediction | None:
        """What the model tells of the threshold, or why it tells nothing: a ramp that has ended is not lost for it."""
        fields = sorted(f for f, shots in self._state.seen.items() if shots)
        if self._model is None or self._shot is None or not fields:
            return None
        label = self._model.label
        try:
            found = self._looks.predicted(self._model, self._shot, self._main_hz, fields[0], fields[-1])
        except (PlatformError, ValueError) as error:
            return RampPrediction(model=label, threshold_t=None, why=str(error))
        return RampPrediction(model=label, threshold_t=found.field_t, highest_field_t=found.highest_t)

    def conclude(self, job: str, result: ProcedureResult) -> None:
        """See Procedure.  Keeps what was found with the specimen."""
        found = self.outcome
        if found is not None:
            self._kept = self._keep(found, job)

    def _see(self, field_t: float, report: StepReport) -> None:
        assert self._files is not None
        if report.reason is not None and "saturated" in report.reason:
            raise DeviceFault(
                "the receiver saturates", where=f"{1e6 * field_t:.4g} uT", why=report.reason,
                remedy="lower the gain of the amplifier (receive.lna_gain), and ramp again",
            )  # fmt: skip
        blank = [self._files.file(frame) for frame in report.frames if self._files.blank(frame)]
        if blank and not self._known:
            self._looks.learn(blank)
            self._known = True
        usable = [self._files.file(frame) for frame in report.frames if self._files.usable(frame)]
        self._unseen += usable
        self._shot = usable[-1] if usable else self._shot
        if self._known:
            self._state.see(field_t, self._looks.of(self._unseen))
            self._unseen = []
        angle, main = report.results.get("phi_max_rad"), report.results.get("f_nat_hz")
        if angle is not None:
            self._angles.setdefault(field_t, []).append(angle.median)
        self._main_hz = main.median if main is not None else self._main_hz

    @property
    def outcome(self) -> RampOutcome | None:
        """See Procedure."""
        fields = sorted(f for f, shots in self._state.seen.items() if shots)
        if not fields:
            return None
        found, highest = self._state.threshold_t(), fields[-1]
        threshold = None if found is None else RampThreshold(value=found[0], low=found[1], high=found[2])
        most = None if threshold is None or not self._angles else min(threshold.value, self._plan.max_t)
        lines = tuple(self._line(line) for line in self._state.seen[highest][-1].lines)
        return RampOutcome(
            kind="ramp",
            visible_am2_per_s=self._state.level,
            threshold_t=threshold,
            operating_field_t=None if most is None else OPERATING_SHARE * most,
            max_field_t=most,
            highest_field_t=highest,
            ended_by=self._state.ended_by() if self._ended else None,
            false_stop_rate=self._plan.false_stop_rate,
            overdose_rate=self._plan.overdose_rate,
            steps=tuple(self._told(f) for f in fields),
            threshold_chances=self._chances(),
            next_field=self._next(),
            predicted=self._prediction,
            lines=lines,
            lines_hz=tuple(line.frequency_hz for line in lines),
            overshoot_t=0.0 if threshold is None else max(0.0, highest - threshold.value),
            drive_saturated=self._saturated(),
            specimen_file=self._kept or None,
        )

    def _told(self, field_t: float) -> RampStep:
        angles = self._angles.get(field_t)
        return RampStep(
            field_t=field_t,
            shots=len(self._state.seen[field_t]),
            phi_max_rad=None if not angles else sum(angles) / len(angles),
            z_residual_am2_per_s=self._state.size(field_t),
            statistic=self._state.statistic(field_t),
            verdict=self._state.verdict(field_t),
        )

    def _chances(self) -> tuple[RampChance, ...]:
        assert self._state.posterior is not None  # a field has been seen
        fields, chances = self._state.posterior.curve()
        return tuple(RampChance(field_t=f, chance=c) for f, c in zip(fields.tolist(), chances.tolist(), strict=True))

    def _next(self) -> RampNextField | None:
        decided = None if self._ended else self._state.decided()
        if decided is None:
            return None
        assert self._state.posterior is not None
        field_t, why = decided
        return RampNextField(field_t=field_t, chance=self._state.posterior.chance_below(field_t), why=why)

    def _line(self, line: SideLine) -> RampLine:
        main = self._main_hz
        near = [n for k, n in _MULTIPLES if main is not None and abs(line.frequency_hz - k * main) < _NEAR * k * main]
        return RampLine(
            frequency_hz=line.frequency_hz, size_am2_per_s=line.size_am2_per_s, near=near[0] if near else "f_side"
        )

    def _saturated(self) -> bool:
        known = sorted((f, sum(a) / len(a)) for f, a in self._angles.items())
        far = [pair for pair in known if pair[0] < known[-1][0] - 2.5 * self._plan.step_t]
        if not far:
            return False
        (f0, a0), (f1, a1) = far[-1], known[-1]
        return (a1 / a0 - 1.0) < _SATURATED * (f1 / f0 - 1.0)


def ramp_of(bench: ProcedureBench, request: RampRequest) -> Ramp:
    """The procedure, also as a part of a characterisation.  Raises InputError."""
    acquisition = request.acquisition
    planned = bench.plan_series(acquisition.model_copy(update={"beyond_side_modes": True}))
    limit_t, earlier = planned.side.limits.max_field_t, planned.specimen.side_modes
    bound: RampBound = "platform_limit"
    if earlier is not None and not acquisition.beyond_side_modes and earlier.max_field_t < limit_t:
        limit_t, bound = earlier.max_field_t, "earlier_ramp"
    plain = acquisition.model_copy(update={"beyond_side_modes": True, "sequence": SequencePatch()})
    preset = bench.plan_series(plain).sequence
    basis = RampBasis(
        sequence=planned.sequence,
        limit_t=limit_t,
        bound=bound,
        period_s=preset.rx_s + preset.pause_s,
        check=bench.plan_series,
        model=None
        if request.predicted_by is None
        else model_with_error(request.predicted_by, bench.engine.models, planned.specimen.variant),
    )
    keep = _keep(bench, acquisition.resonator, planned.specimen)
    return Ramp(request, basis, keep, ComputedSideModes(bench.engine.computing))


def _keep(bench: ProcedureBench, name: str, specimen: Specimen) -> Keep:
    """By name in the catalogue; of a resonator that a file declares, as a file next to the recording."""
    shelf = bench.engine.catalogue.resonators
    if (shelf.added is not None and name in shelf.files()) or bench.files.target is None:
        return save_to_catalogue(bench.engine.catalogue, name)
    return save_with_recording(specimen, bench.files.target.with_suffix(".toml"))


def plan(bench: ProcedureBench, request: RampRequest) -> ProcedureWork:
    """The work of a ramp.  Raises InputError."""
    return bench.work(ramp_of(bench, request))
