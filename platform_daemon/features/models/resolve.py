"""Names of models wherever a model is chosen: declared ones, with further terms, or adopted ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from drivers.errors import InputError, RecordingError
from platform_daemon.core.schemas.model_names import DECLARED_MODELS, check_model_name, torque_terms

from .adopted_model import AdoptedModel
from .library import Library, UnknownModel

if TYPE_CHECKING:
    from platform_daemon.core.recordings.recording import Recording
    from platform_daemon.estimation.physics.models import RingDownModel

ModelChoice = str | AdoptedModel
"""A declared model by its name, or an adopted one."""


def resolve(text: str | None, library: Library | None) -> ModelChoice | None:
    """A declared name as it is, an adopted one as its model.  Raises InputError, with the names there are."""
    if text is None or library is None or text.partition("+")[0] in DECLARED_MODELS:
        return text
    try:
        return library.get(text)
    except UnknownModel as unknown:
        remedy = f"declared are: {', '.join(DECLARED_MODELS)}; {unknown.remedy}"
        raise InputError(f"no variant {text!r}", where="variant", why=unknown.why, remedy=remedy) from None


def with_terms(model: ModelChoice, terms: Sequence[str]) -> ModelChoice:
    """A model with further torque terms, none of which an adopted one takes.  Raises InputError."""
    if not isinstance(model, AdoptedModel):
        return checked_variant(model, terms)
    if terms:
        remedy = "diagnose on the base of it and adopt what is found, or leave the terms out"
        raise InputError("an adopted model takes no further terms", where=model.label, remedy=remedy)
    return model


def model_of(model: ModelChoice) -> RingDownModel:
    """What a fit takes.  Raises InputError for a name that is not declared, or a term that cannot be used."""
    from platform_daemon.estimation.physics.models import model_named  # here, because numba is loaded with it

    if isinstance(model, AdoptedModel):
        return model.model
    try:
        return model_named(model)
    except ValueError as error:  # a term of another package whose name is known, and which cannot be used
        remedy = "correct the package that publishes the term, or leave the term out"
        raise InputError(str(error), where="variant", remedy=remedy) from None


def checked_variant(variant: str, terms: Sequence[str] = ()) -> str:
    """The name of a declared model with further torque terms.  Raises InputError, with the names there are."""
    name = "+".join((variant, *terms))
    try:
        check_model_name(name)
    except ValueError as error:
        declared, *further = name.split("+")
        unknown = next((term for term in further if term not in torque_terms()), None)
        if declared not in DECLARED_MODELS:
            what, remedy = f"no variant {declared!r}", f"one of: {', '.join(DECLARED_MODELS)}"
        elif unknown is not None:
            what, remedy = f"no torque term {unknown!r}", f"one of: {', '.join(torque_terms())}"
        else:
            what, remedy = str(error), "name each term once, and none that the variant has already"
        raise InputError(what, where="variant", remedy=remedy) from None
    return name


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
        *([] if model.rotor is None else [f"{model.rotor.id} held: a rotor of five degrees of freedom"]),
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
