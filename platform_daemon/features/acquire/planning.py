"""The request of an acquisition, and the checked plan that is made of it before anything moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import structlog

from drivers.errors import SequenceRejected
from drivers.specimen import Specimen
from drivers.validation import validated
from platform_daemon.core.hardware.catalogue import Catalogue
from platform_daemon.core.jobs.run_task import run_task_with_retry
from platform_daemon.core.jobs.workers.deadline import check_deadline
from platform_daemon.core.jobs.workers.task_executor import InProcessExecutor, TaskExecutor
from platform_daemon.core.schemas.acquisitions import AcquisitionSummary, SettleCheck, ShotSummary
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.schemas.value_sources import Origins, ValueSource
from sequences.compiler import ShotPlan, TransmitSide, compile_shot, loop_lag_s, tx_window_s
from sequences.request import SequenceRequest

from .drive_plan import DriveTask
from .sequence_sources import sourced_sequence, specimen_sources
from .settling import Settling, settling

if TYPE_CHECKING:
    from platform_daemon.features.fit.online import NamedModel

log = structlog.get_logger()


@dataclass(frozen=True)
class AcquisitionPlan:
    """Everything decided: specimen, the model of the fits, the checked shots (blank ones first), the settle check, and
    the transmit side that all this holds for."""

    request: AcquisitionRequest
    specimen: Specimen
    specimen_text: str
    model: NamedModel
    sequence: SequenceRequest
    excited: ShotPlan
    blank: ShotPlan
    settle: Settling
    side: TransmitSide
    stale_preset: str | None = None  # why a tuned preset is not used
    planned_phi_max_rad: float | None = None
    changed: tuple[ShotPlan, ...] = ()
    value_sources: tuple[ValueSource, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """What may spoil the series."""
        return tuple(text for text in (self.stale_preset, self.settle.warning) if text is not None)

    @cached_property
    def shots(self) -> list[ShotPlan]:
        """One plan per shot, in order."""
        excited = self.changed or (self.excited,)
        made = [excited[k % len(excited)] for k in range(self.sequence.repetitions)]
        return [self.blank] * self.sequence.blank_shots + made

    @property
    def kinds(self) -> list[tuple[ShotPlan, int]]:
        """Each shot that is planned, and how often it is made: there may be a million of them."""
        excited = self.changed or (self.excited,)
        rounds, rest = divmod(self.sequence.repetitions, len(excited))
        made = [(shot, rounds + (k < rest)) for k, shot in enumerate(excited)]
        return [(self.blank, self.sequence.blank_shots), *made]

    @property
    def shots_in_all(self) -> int:
        """Blank ones included."""
        return sum(count for _, count in self.kinds)

    @property
    def duration_s(self) -> float:
        """Of all shots with the pauses between them, s."""
        pauses_s = (self.shots_in_all - 1) * self.sequence.pause_s
        return pauses_s + sum(n * shot.timeline.duration_s for shot, n in self.kinds)

    @property
    def disk_bytes(self) -> int:
        """Of all samples, uncompressed."""
        return sum(n * shot.timeline.total_samples for shot, n in self.kinds) * 3 * 4

    def changes_of(self, shot: int) -> list[tuple[str, Any]] | None:
        """What the shot of this number, from 0, differs in; None: in nothing."""
        changes, excited = self.request.shot_changes, shot - self.sequence.blank_shots
        return None if changes is None or excited < 0 else list(changes[excited % len(changes)].changes().items())

    def summary(self) -> AcquisitionSummary:
        """The dry run: what would be played, how long it takes, what remains, how much disk it needs."""
        return AcquisitionSummary(
            resonator=self.specimen.name,
            variant=self.specimen.variant,
            model=self.model.label,
            shots=self.shots_in_all,
            shot=ShotSummary.model_validate(self.excited.summary() | {"planned_phi_max_rad": self.planned_phi_max_rad}),
            shots_in_turn=tuple(ShotSummary.model_validate(s.summary()) for s in self.changed) or None,
            duration_s=self.duration_s,
            disk_bytes=self.disk_bytes,
            settle=SettleCheck(remaining_rad=self.settle.remaining_rad, share=self.settle.share),
            value_sources=self.value_sources,
            warnings=self.warnings,
        )


def plan_acquisition(
    request: AcquisitionRequest,
    side: TransmitSide,
    models: Path | None = None,
    catalogue: Catalogue = Catalogue(),  # noqa: B008 frozen
    computer: TaskExecutor = InProcessExecutor(),  # noqa: B008 without state
    origins: Origins = MappingProxyType({}),
) -> AcquisitionPlan:
    """The checked plan.  computer: plans drives; origins: see sourced_sequence.

    Raises ConfigError for a wrong key, InputError for an unknown model, SequenceRejected outside the envelope,
    OverBounds once the time for it is over (`in_time`); nothing moves.
    """
    from platform_daemon.features.fit.online import checked_model

    check_deadline()
    specimen, text = catalogue.resonators.load(request.resonator)
    model = checked_model(request.variant or specimen.variant, models)
    sourced = sourced_sequence(request, specimen, catalogue, origins)
    sequence = sourced.sequence
    if sequence.repetitions + sequence.blank_shots == 0:
        raise SequenceRejected("no shot is requested", where="shots", remedy="request at least one shot or blank shot")
    _check_side_modes(request, specimen, sequence)
    changed = _changed(request, sequence)
    planned = [excited_shot(each, side, specimen, model, computer) for each in changed or (sequence,)]
    excited, reached = planned[0]
    blank = compile_shot(excited.request, side, blank=True)
    # Of the shot that swings furthest, which takes longest to come to rest.
    threshold = side.limits.settle_warning
    check = max((settling(s, specimen, threshold, sourced.damping) for s, _ in planned), key=lambda c: c.start_rad)
    return AcquisitionPlan(
        request,
        specimen,
        text,
        model,
        sequence,
        excited,
        blank,
        check,
        side,
        sourced.stale_preset,
        reached,
        tuple(s for s, _ in planned) if changed else (),
        (*specimen_sources(request.resonator, specimen, catalogue.resonators), *sourced.sources),
    )


def _changed(request: AcquisitionRequest, sequence: SequenceRequest) -> list[SequenceRequest]:
    """The sequence of every shot that is changed.  Raises ConfigError that names the shot."""
    table = sequence.model_dump()
    return [
        validated(SequenceRequest, {**table, **change.changes()}, f"shot_changes.{k}")
        for k, change in enumerate(request.shot_changes or ())
    ]


def excited_shot(
    sequence: SequenceRequest,
    side: TransmitSide,
    specimen: Specimen,
    model: NamedModel,
    computer: TaskExecutor,
    fitted: Mapping[str, float] | None = None,
) -> tuple[ShotPlan, float | None]:
    """The checked shot, and the deflection that the model reaches under a planned drive, rad; None: it is not planned.

    fitted: of the last good fit, by public name.  Raises SequenceRejected, OverBounds.
    """
    check_deadline()
    if sequence.phase_plan == "none":
        return compile_shot(sequence, side), None
    task = DriveTask(sequence, tx_window_s(sequence, side), specimen, model, loop_lag_s(sequence, side), fitted)
    plan = run_task_with_retry(computer, "planning", task)
    return compile_shot(sequence, side, planned=plan.lobes), plan.phi_max_rad


def _check_side_modes(request: AcquisitionRequest, specimen: Specimen, sequence: SequenceRequest) -> None:
    """Raises SequenceRejected above the highest field that a ramp has found, unless that was requested."""
    found = specimen.side_modes
    if found is None or sequence.repetitions == 0 or sequence.field_t <= found.max_field_t * (1.0 + 1e-9):
        return
    if not request.beyond_side_modes:
        raise SequenceRejected(
            f"{1e6 * sequence.field_t:.6g} uT lies above the field at which this resonator shows side modes, "
            f"{1e6 * found.max_field_t:.6g} uT",
            where="sequence.field_t",
            why=f"found on {found.found}: {found.evidence}",
            remedy=f"stay below, as at {1e6 * found.operating_field_t:.4g} uT; or allow it (beyond_side_modes, on the "
            "command line --beyond-side-modes)",
        )
    log.warning(
        "beyond_side_modes", resonator=specimen.name, field_t=sequence.field_t, max_field_t=found.max_field_t,
        operator=request.operator,
    )  # fmt: skip


def untuned_sequence(request: AcquisitionRequest, specimen: Specimen, catalogue: Catalogue) -> SequenceRequest:
    """The sequence of a request without what tune has found.  Raises ConfigError, InputError."""
    return sourced_sequence(request, specimen, catalogue, {}, use_tuned=False).sequence
