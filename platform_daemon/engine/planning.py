"""What an acquisition is asked to be, and the checked plan it becomes before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drivers.errors import SequenceRejected
from drivers.specimen import Specimen
from drivers.validation import validated
from platform_daemon import analysis
from platform_daemon.schemas import AcquisitionRequest, AcquisitionSummary, SettleCheck, ShotSummary
from platform_daemon.settings import load_sequence, refuse_foreign_preset
from sequences.compiler import ShotPlan, TransmitSide, compile_shot
from sequences.request import SequenceRequest

from .catalogue import Catalogue
from .settling import Settling, settling

if TYPE_CHECKING:
    from platform_daemon.analysis import Library, ModelChoice


@dataclass(frozen=True)
class AcquisitionPlan:
    """Everything decided: specimen, the model of the fits, the checked shots (blank ones first), the settle check, and
    the transmit side that all this holds for."""

    request: AcquisitionRequest
    specimen: Specimen
    specimen_text: str
    model: ModelChoice
    sequence: SequenceRequest
    excited: ShotPlan
    blank: ShotPlan
    settle: Settling
    side: TransmitSide
    stale_preset: str | None = None  # why a tuned preset is not used

    @property
    def warnings(self) -> tuple[str, ...]:
        """What may spoil the series."""
        return tuple(text for text in (self.stale_preset, self.settle.warning) if text is not None)

    @property
    def shots(self) -> list[ShotPlan]:
        """One plan per shot, in order."""
        return [self.blank] * self.sequence.blank_shots + [self.excited] * self.sequence.repetitions

    def summary(self) -> AcquisitionSummary:
        """The dry run: what would be played, how long it takes, what remains, how much disk it needs."""
        total = len(self.shots)
        return AcquisitionSummary(
            resonator=self.specimen.name,
            variant=self.specimen.variant,
            model=analysis.label_of(self.model),
            shots=total,
            shot=ShotSummary.model_validate(self.excited.summary()),
            duration_s=total * (self.excited.timeline.duration_s + self.sequence.pause_s),
            disk_bytes=total * self.excited.timeline.total_samples * 3 * 4,
            settle=SettleCheck(remaining_rad=self.settle.remaining_rad, share=self.settle.share),
            warnings=self.warnings,
        )


def plan_acquisition(
    request: AcquisitionRequest,
    side: TransmitSide,
    models: Library | None = None,
    catalogue: Catalogue = Catalogue(),  # noqa: B008 frozen
) -> AcquisitionPlan:
    """The checked plan.

    Raises ConfigError for a wrong key, InputError for an unknown model, SequenceRejected outside the envelope;
    nothing moves.
    """
    specimen, text = catalogue.resonators.load(request.resonator)
    model = analysis.resolve(request.variant or specimen.variant, models)
    assert model is not None
    if isinstance(model, str):
        model = analysis.checked_variant(model)
    tuned, stale = catalogue.tuned.keys_for(request.resonator, specimen)
    sequence = _sequence(request, specimen, catalogue, tuned.changes())
    if sequence.repetitions + sequence.blank_shots == 0:
        raise SequenceRejected("no shot was asked for", where="shots", remedy="ask for at least one shot or blank shot")
    excited = compile_shot(sequence, side)
    blank = compile_shot(sequence, side, blank=True)
    check = settling(excited, specimen, side.limits.settle_warning)
    return AcquisitionPlan(request, specimen, text, model, sequence, excited, blank, check, side, stale)


def untuned_sequence(request: AcquisitionRequest, specimen: Specimen, catalogue: Catalogue) -> SequenceRequest:
    """The sequence of a request without what tune has found.  Raises ConfigError, InputError."""
    return _sequence(request, specimen, catalogue, {})


def _sequence(
    request: AcquisitionRequest, specimen: Specimen, catalogue: Catalogue, tuned: dict[str, Any]
) -> SequenceRequest:
    preset = load_sequence(specimen.variant).model_dump() | tuned | _named(request.preset, specimen, catalogue)
    counts = {"repetitions": request.shots, "blank_shots": request.blank_shots}
    return validated(SequenceRequest, {**preset, **counts, **request.sequence.changes()}, "sequence")


def _named(preset: str | None, specimen: Specimen, catalogue: Catalogue) -> dict[str, Any]:
    """The keys of a sequence of the catalogue.  Raises InputError for the preset that ships for the other bearing."""
    if preset is None:
        return {}
    remedy = "leave `preset` out, or give the keys that differ as `sequence`"
    refuse_foreign_preset(catalogue.sequences.path(preset), specimen, "preset", remedy)
    return catalogue.sequences.named(preset).changes()
