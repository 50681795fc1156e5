"""Ramp: the field is raised until side modes show in the z channel, never where they are too likely to (paper,
"Measurement Sequence")."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

from drivers.errors import DeviceFault, InputError, PlatformError
from platform_daemon import analysis
from platform_daemon.schemas import (
    MOST_STEPS,
    AcquisitionRequest,
    ProcedureResult,
    RampLine,
    RampOutcome,
    RampRequest,
    RampStep,
    RampThreshold,
    StepReport,
    SweptValue,
)
from sequences.request import SequenceRequest

from .kept_limits import Keep
from .procedure import ShotFiles, Step, StepSequence

OPERATING_SHARE = 0.8
"""Of the threshold, at which a resonator is to be used (paper, "Measurement Sequence")."""
_START_SHARE = 0.5  # of the preset's field
_LONGEST_RX_S = 2.0  # side modes are gone by then
_NEVER_RINGS = 3  # shots
_LEARN = 3  # blank shots, which tell the noise: side modes begin far below where they are seen
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

    def of(self, shots: Sequence[Path]) -> list[analysis.ZResidual]:
        """What recorded shots show out of the plane.  Raises RecordingError."""


@dataclass(frozen=True)
class RampBasis:
    """What a ramp starts from: the sequence of the resonator, and the highest field allowed, T: by the platform, and by
    an earlier ramp unless it may go beyond that. period_s: of listening and pause in the preset, which lets it rest."""

    sequence: SequenceRequest
    limit_t: float
    period_s: float


class Ramp:
    """See Procedure.  Raises InputError for fields that cannot be."""

    def __init__(self, request: RampRequest, basis: RampBasis, keep: Keep, looks: SideModes) -> None:
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
        self._plan = analysis.RampPlan(
            start, request.step_t, most, request.overdose_rate, request.false_stop_rate, request.most_shots
        )
        self._state = analysis.Escalation(self._plan)
        self._f_tx_hz = basis.sequence.f_tx_hz
        self._rx_s = min(basis.sequence.rx_s, _LONGEST_RX_S)
        # The rotor is to be at rest again: what a shot no longer listens to, it waits.
        self._pause_s = max(0.0, basis.period_s - self._rx_s)
        self._given = request.acquisition.sequence.changes()
        self._keep, self._kept = keep, ""
        self._looks = looks
        self._files: ShotFiles | None = None
        self._known = False  # the noise
        self._unseen: list[Path] = []  # shots at the first field, made before it
        self._angles: dict[float, list[float]] = {}
        self._main_hz: float | None = None

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
        """From now on shots are made with these keys of a sequence, where others were not asked for."""
        self._given = {k: v for k, v in keys.items() if k not in ("field_t", "rx_s", "pause_s")} | self._given

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

    def _step(self, field_t: float, blank: int) -> Step:
        asked = self._given | {"field_t": field_t}
        asked |= {k: v for k, v in (("rx_s", self._rx_s), ("pause_s", self._pause_s)) if k not in self._given}
        tables = self.request.acquisition.model_dump(exclude_none=True) | {
            "sequence": asked, "shots": 1, "blank_shots": blank,
        }  # fmt: skip
        made = AcquisitionRequest.model_validate(tables)
        # Until something rings a shot is listened to: what moves in many ways at once is not fitted, but rings.
        near_hz = None if self._known else asked.get("f_tx_hz", self._f_tx_hz)
        return Step((SweptValue(key="field_ut", value=round(1e6 * field_t, 6)),), made, near_hz)

    def steps(self) -> StepSequence:
        """See Procedure.  Raises NeverRings, RecordingError; DeviceFault for a receiver that saturates."""
        looked = silent = 0
        while (field_t := self._state.next_field()) is not None:
            # Blank ones once something rings: nobody waits for them where nothing does.
            report = yield self._step(field_t, _LEARN if looked and not self._known else 0)
            self._see(field_t, report)
            rings = report.fitted > 0 or report.heard is not None
            looked += rings
            silent = 0 if rings else silent + 1
            if not looked and silent >= _NEVER_RINGS:
                raise NeverRings(
                    f"no ring-down in {silent} shots",
                    where=f"{1e6 * field_t:.4g} uT along {self.request.acquisition.sequence.axis or 'the preset axis'}",
                    why=report.reason or "",
                    remedy="check that the resonator is mounted, its f_tx_hz and the axis; or start at a higher field",
                )
        return self._state.why_ended()

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
        self._unseen += [self._files.file(frame) for frame in report.frames if self._files.usable(frame)]
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
        most = highest if threshold is None else min(threshold.value, self._plan.max_t)
        known = bool(self._angles) and not self._state.began_above
        lines = tuple(self._line(line) for line in self._state.seen[highest][-1].lines)
        return RampOutcome(
            kind="ramp",
            visible_am2_per_s=self._state.level,
            threshold_t=threshold,
            operating_field_t=OPERATING_SHARE * most if known else None,
            max_field_t=most if known else None,
            false_stop_rate=self._plan.false_stop_rate,
            overdose_rate=self._plan.overdose_rate,
            steps=tuple(self._told(f) for f in fields),
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

    def _line(self, line: analysis.SideLine) -> RampLine:
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
