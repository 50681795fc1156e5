"""Names of models wherever a variant is accepted: declared ones, with further terms, or adopted ones."""

from __future__ import annotations

from dataclasses import replace

from drivers.errors import InputError, RecordingError
from platform_daemon.estimation import MODELS, RingDownModel, model_named
from platform_daemon.store import Recording

from .adopted_model import AdoptedModel
from .library import Library, UnknownModel

ModelChoice = str | AdoptedModel
"""A declared model by its name, or an adopted one."""


def resolve(text: str | None, library: Library | None) -> ModelChoice | None:
    """A declared name as it is, an adopted one as its model.  Raises InputError, with the names there are."""
    if text is None or library is None or text.partition("+")[0] in MODELS:
        return text
    try:
        return library.get(text)
    except UnknownModel as unknown:
        remedy = f"declared are: {', '.join(MODELS)}; {unknown.remedy}"
        raise InputError(f"no variant {text!r}", where="variant", why=unknown.why, remedy=remedy) from None


def model_of(variant: ModelChoice) -> RingDownModel:
    """What a fit takes.  Raises ValueError for a name that is not declared."""
    return variant.model if isinstance(variant, AdoptedModel) else model_named(variant)


def label_of(variant: ModelChoice) -> str:
    """What results are marked with."""
    return variant.label if isinstance(variant, AdoptedModel) else variant


def notes_of(variant: ModelChoice) -> list[str]:
    """What a reader of results must know of an adopted model."""
    if not isinstance(variant, AdoptedModel):
        return []
    added = [
        *(f"{t.term} {'free' if t.free else 'held'}" for t in variant.terms),
        *(f"{r.id} undone" for r in variant.receiver),
    ]
    retired = "" if variant.retired is None else "; it is retired"
    return [
        f"adopted model {variant.label} (sha256 {variant.digest[:12]}): {variant.base} with {', '.join(added)}{retired}"
    ]


def with_receiver_correction(recording: Recording, variant: ModelChoice) -> Recording:
    """A recording whose calibration undoes the receiver effects of the model.

    Raises RecordingError if it has no calibration, or one with which they cannot be undone.
    """
    if not isinstance(variant, AdoptedModel) or not variant.receiver:
        return recording
    used = recording.calibration
    if used is None or used.sensitivity.shape != (3, 3):
        raise RecordingError(
            f"{variant.label} cannot be used here",
            where=f"{recording.path}: /calibration/sensitivity",
            why="it undoes effects of a receiver of three channels, which takes their sensitivity",
            remedy="name a calibration, or use a model without receiver effects",
        )
    return recording.with_calibration(replace(used, receiver=variant.receiver))
