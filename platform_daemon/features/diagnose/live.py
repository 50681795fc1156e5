"""The loop: measure, diagnose, run the next measurement that the diagnosis proposes, diagnose all shots together.

Every series is a recording of its own; `LiveDiagnosis.log` says what was measured, why, and what it brought.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivers.errors import InputError
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.schemas.value_sources import value_sources_text
from platform_daemon.diagnosis.report_schema import DiagnosisReport
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.planning import AcquisitionPlan
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.features.acquire.work import AcquisitionJob

from .live_schema import DiagnosedRound, EffectSummary, LiveDiagnosisLog, ManualStep, UndiagnosedRound

if TYPE_CHECKING:
    from platform_daemon.diagnosis.diagnose import Diagnosis
    from platform_daemon.diagnosis.findings.next_measurements import Measurement, Proposal
    from platform_daemon.diagnosis.selection.stepwise import ProgressCallback
    from platform_daemon.features.models.resolve import ModelChoice

    Step = tuple[str, str, AcquisitionPlan, Proposal | None]
    """Key of the measurement, why it is made, its plan, and the proposal that it follows."""

NEVER_AT_ONCE = ("calibrate_2f",)  # ends in another calibration file, not in another series
_OUT_OF_BUDGET = "out of budget"
_FIELDS = (0.5, 0.25)  # of the first series
_WINDOWS = (2.0, 4.0)
_SHOTS = (4, 8)
_BLANKS = 4


@dataclass(frozen=True)
class Budget:
    """How much may be measured: shots in all, and seconds after which no further series begins."""

    shots: int
    seconds: float


def _wait(job: AcquisitionJob) -> None:
    job.ended.wait()


@dataclass(frozen=True)
class Callbacks:
    """How the loop talks: `acquired` waits for a job and shows it, `tell` shows a diagnosis, `say` prints a line.

    confirmed: asks the operator for a manual step; True: it is done, False: skip it.
    """

    acquired: Callable[[AcquisitionJob], None] = _wait
    tell: ProgressCallback = lambda what, share: None
    say: Callable[[str], None] = lambda text: None
    confirmed: Callable[[Measurement], bool] = lambda step: False


@dataclass
class LiveDiagnosis:
    """One loop on one resonator.

    Attributes:
        engine, first: the platform, and the request of the first series.
        folder: where series and nothing else are written.
        model: declared or adopted, None: the resonator's.
        rounds: what was done; found, report: the last diagnosis; stopped: why it ended;
        left: manual steps that were not done.
    """

    engine: Engine
    first: AcquisitionRequest
    folder: Path
    budget: Budget
    callbacks: Callbacks = field(default_factory=Callbacks)
    model: ModelChoice | None = None
    rounds: list[DiagnosedRound | UndiagnosedRound] = field(default_factory=list)
    found: Diagnosis | None = None
    report: DiagnosisReport | None = None
    stopped: str = "interrupted"
    left: dict[str, str] = field(default_factory=dict)
    _files: list[Path] = field(default_factory=list)
    _done: dict[str, int] = field(default_factory=dict)
    _shots: int = 0
    _began_s: float = field(default_factory=time.monotonic)

    def run(self) -> None:
        """Go on until explained, out of ideas or out of budget.

        Raises InputError if the first series cannot be planned or holds nothing to diagnose, and what the platform
        raises; what was measured stays on disk and in the log.
        """
        why = "what the declared model leaves over"
        todo: Step | None = ("first_series", why, plan_series(self.engine, self._affordable(self.first)), None)
        while todo is not None:
            self._round(*todo)
            self.stopped = self._reason_to_stop()
            if self.stopped:
                if self.stopped.startswith(_OUT_OF_BUDGET):
                    self._list_manual_steps()
                return
            todo = self._next()
        self.stopped = "out of ideas: no proposed measurement is left that the platform can do by itself"

    def log(self) -> LiveDiagnosisLog:
        """What was measured, why, what it brought, and the last diagnosis."""
        from platform_daemon.core.recordings.evidence import file_digests

        return LiveDiagnosisLog(
            stopped=self.stopped,
            shots=self._shots,
            seconds=time.monotonic() - self._began_s,
            rounds=tuple(self.rounds),
            manual_steps_left=tuple(ManualStep(id=k, what=v) for k, v in self.left.items()),
            recordings=file_digests(self._files),
            files=tuple(map(str, self._files)),
            diagnosis=self.report,
        )

    def _round(self, key: str, why: str, plan: AcquisitionPlan, proposal: Proposal | None) -> None:
        """Measure a series, diagnose all shots so far, write down what it brought."""
        from platform_daemon.diagnosis.report import diagnosis_report

        from .load_shots import diagnose_input, load_diagnosis_input

        began, shots, before, number = time.monotonic(), self._shots, self.report, len(self.rounds) + 1
        path = self._free_path(key)
        self.callbacks.say(f"round {number}: {key}: {why}")
        try:
            self.callbacks.say(value_sources_text(plan.value_sources))
            self._measure(plan, path)
            self.found = diagnose_input(load_diagnosis_input(self._files, self.model), self.callbacks.tell)
            self.report = diagnosis_report(self.found)
            self.callbacks.say(f"  {_in_words(self.report)}")
        finally:
            series = UndiagnosedRound(
                round=number, measurement=key, why=why, file=str(path), shots=self._shots - shots,
                field_t=plan.sequence.field_t, rx_s=plan.sequence.rx_s, axis=plan.sequence.axis,
                expected_sigma=None if proposal is None else proposal.expected_sigma,
                seconds=time.monotonic() - began, value_sources=plan.value_sources,
            )  # fmt: skip
            now = self.report
            self.rounds.append(series if now is None or now is before else _brought(series, before, now))

    def _measure(self, plan: AcquisitionPlan, path: Path) -> None:
        """A series; its shots count also where it is cut short."""
        job = self.engine.submit(series_work(self.engine, plan, OwnFile(path, self.folder)))
        try:
            self.callbacks.acquired(job)
        except KeyboardInterrupt:
            self.engine.outputs_off()
            job.ended.wait(timeout=60)
            raise
        finally:
            self._shots += job.result.shots or 0
            self._files += [path] if path.exists() else []
        if job.error is not None:
            raise job.error

    def _free_path(self, key: str) -> Path:
        """A new name: an earlier loop in the same folder is not overwritten."""
        number = len(self.rounds) + 1
        while (path := self.folder / f"round{number:02d}-{key}.h5").exists():
            number += 1
        return path

    def _reason_to_stop(self) -> str:
        """Why the search ends; empty: it continues."""
        assert self.found is not None
        if self.found.verdict == "nothing_missing":
            return "nothing is missing"
        if self.found.verdict == "explained" and not _confused(self.found):
            return "explained, and told apart from look-alikes"
        if self._shots >= self.budget.shots:
            return f"{_OUT_OF_BUDGET}: shots"
        return f"{_OUT_OF_BUDGET}: time" if time.monotonic() - self._began_s >= self.budget.seconds else ""

    def _next(self) -> Step | None:
        """The best proposal that can be carried out, planned."""
        assert self.found is not None
        for proposal in self.found.next_measurements:
            m = proposal.measurement
            why = (
                f"separates {', '.join(proposal.separates)}" if proposal.separates else "narrows down what has no name"
            )
            if not m.automatic:
                if not self._manual(m):
                    continue
                return m.key, why, plan_series(self.engine, self._affordable(self.first)), proposal
            for request in self._requests(m.key):
                self._done[m.key] = self._done.get(m.key, 0) + 1
                try:
                    return m.key, why, plan_series(self.engine, self._affordable(request)), proposal
                except InputError as error:  # outside the safety envelope: the next proposal may be inside
                    self.callbacks.say(f"  {m.key} is not possible: {error}")
        return None

    def _manual(self, step: Measurement) -> bool:
        """Ask for a manual step once."""
        if step.key in self._done or step.key in self.left:
            return False
        if step.key in NEVER_AT_ONCE or not self.callbacks.confirmed(step):
            self.left[step.key] = step.what
            return False
        self._done[step.key] = 1
        return True

    def _list_manual_steps(self) -> None:
        """Those that the last diagnosis proposes, wherever it ranks them: a person may do them without the platform."""
        assert self.found is not None
        for step in (proposal.measurement for proposal in self.found.next_measurements):
            if not step.automatic and step.key not in self._done:
                self.left.setdefault(step.key, step.what)

    def _requests(self, key: str) -> Iterator[AcquisitionRequest]:
        """What is left to try of an automatic measurement."""
        yield from variations(self.first, plan_series(self.engine, self.first), key)[self._done.get(key, 0) :]

    def _affordable(self, request: AcquisitionRequest) -> AcquisitionRequest:
        """With no more shots than the budget has left."""
        left = max(1, self.budget.shots - self._shots)
        shots = min(request.shots, left)
        return request.model_copy(update={"shots": shots, "blank_shots": min(request.blank_shots, left - shots)})


def variations(first: AcquisitionRequest, plan: AcquisitionPlan, key: str) -> list[AcquisitionRequest]:
    """The series that an automatic measurement stands for, the gentlest first."""

    def changed(**keys: Any) -> AcquisitionRequest:
        return first.model_copy(update={"sequence": first.sequence.model_copy(update=keys)})

    if key == "second_amplitude":
        return [changed(field_t=share * plan.sequence.field_t) for share in _FIELDS]
    if key == "twice_the_field":
        return [changed(field_t=2.0 * plan.sequence.field_t)]
    if key == "longer_window":
        return [changed(rx_s=times * plan.sequence.rx_s) for times in _WINDOWS]
    if key == "more_shots":
        return [first.model_copy(update={"shots": times * first.shots}) for times in _SHOTS]
    if key == "blank_shots":
        return [first.model_copy(update={"blank_shots": _BLANKS})]
    if key == "other_excitation_axis":
        return [changed(axis=axis) for axis in _other_axes(plan)]
    return []


def _other_axes(plan: AcquisitionPlan) -> list[tuple[float, ...]]:
    """Directions 45 degrees from the present one: along other world axes a rotor may not be driven at all."""
    now = plan.sequence.direction()
    along = int(abs(now).argmax())
    found = []
    for other in range(3):
        if other != along:
            turned = now.copy()
            turned[other] += 1.0
            found.append(tuple(float(x) for x in turned))
    return found


def _confused(found: Diagnosis) -> bool:
    """True if a named effect has a look-alike of another name."""
    return any(r.candidate.effect.id != n.candidate.effect.id for n in found.named for r in n.confounders)


def _brought(series: UndiagnosedRound, before: DiagnosisReport | None, now: DiagnosisReport) -> DiagnosedRound:
    """With what the series changed."""
    return DiagnosedRound(
        **dict(series),
        verdict_before=None if before is None else before.verdict,
        verdict=now.verdict,
        effects_before=() if before is None else _summaries(before),
        effects=_summaries(now),
        gain_left_over=now.left_over.gain,
    )


def _summaries(report: DiagnosisReport) -> tuple[EffectSummary, ...]:
    return tuple(
        EffectSummary(id=e.id, strength=e.strength, indistinguishable_from=e.indistinguishable_from)
        for e in report.effects
    )


def _in_words(report: DiagnosisReport) -> str:
    parts = []
    for e in report.effects:
        alike = f" (or {', '.join(e.indistinguishable_from)})" if e.indistinguishable_from else ""
        value, std = (math.nan if x is None else x for x in (e.strength.value, e.strength.std))
        parts.append(f"{e.id} {value:.4g} +- {std:.2g} {e.strength.unit}{alike}")
    return f"{report.verdict}: {'; '.join(parts) or 'no effect has a name'}"
