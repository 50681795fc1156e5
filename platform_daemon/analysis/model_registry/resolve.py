"""Names of models wherever a model is chosen: declared ones, with further terms, or adopted ones."""

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


def model_of(model: ModelChoice) -> RingDownModel:
    """What a fit takes.  Raises ValueError for a name that is not declared."""
    return model.model if isinstance(model, AdoptedModel) else model_named(model)


def label_of(model: ModelChoice) -> str:
    """What results are marked with."""
    return model.label if isinstance(model, AdoptedModel) else model


def notes_of(model: ModelChoice) -> list[str]:
    """What a reader of results must know of an adopted model."""
    if not isinstance(model, AdoptedModel):
        return []
    added = [
        *(f"{t.term} {'free' if t.free else 'held'}" for t in model.terms),
        *(f"{r.id} undone" for r in model.receiver),
    ]
    retired = "" if model.retired is None else "; it is retired"
    return [f"adopted model {model.label} (sha256 {model.digest[:12]}): {model.base} with {', '.join(added)}{retired}"]


def with_receiver_correction(recording: Recording, model: ModelChoice) -> Recording:
    """A recording whose calibration undoes the receiver effects of the model.

    Raises RecordingError if it has no calibration, or one with which they cannot be undone.
    """
    if not isinstance(model, AdoptedModel) or not model.receiver:
        return recording
    used = recording.calibration
    if used is None or used.sensitivity.shape != (3, 3):
        raise RecordingError(
            f"{model.label} cannot be used here",
            where=f"{recording.path}: /calibration/sensitivity",
            why="it undoes effects of a receiver of three channels, which takes their sensitivity",
            remedy="name a calibration, or use a model without receiver effects",
        )
    return recording.with_calibration(replace(used, receiver=model.receiver))
