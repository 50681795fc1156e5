"""Models that follow from the kind of a job: its record on disk, and the job and the list of jobs that REST shows."""

from __future__ import annotations

import types
from functools import cache
from typing import Any, Literal

from pydantic import ConfigDict, Field, TypeAdapter

from drivers.errors import InputError
from platform_daemon.core.registry import Feature, feature_of
from platform_daemon.core.schemas.base import ListPage, Schema, example
from platform_daemon.core.schemas.jobs import AnyJobRecord, Job, JobRecord, QueuedJob

_OBJECT = TypeAdapter(dict[str, Any])


@cache
def record_type(kind: str) -> type[AnyJobRecord]:
    """Model of the record of a job of that kind.  Raises InputError for a kind that no feature has."""
    feature = feature_of(kind)
    base = JobRecord[feature.request_type, feature.result_type]  # type: ignore[name-defined]
    return _model(f"{_pascal(kind)}Record", base, f"The record of a job: {feature.kind.article.lower()}.", feature)


def record_from_json(text: str | bytes) -> AnyJobRecord:
    """A record of any kind.  Raises ValueError, also for a kind that no feature has."""
    kind = str(_OBJECT.validate_json(text).get("kind"))
    try:
        model = record_type(kind)
    except InputError as error:
        raise ValueError(str(error)) from None
    return model.model_validate_json(text)


@cache
def job_type(kind: str) -> type[Job[Any, Any]]:
    """Model of a job of that kind as REST shows it."""
    feature = feature_of(kind)
    shown = QueuedJob if feature.kind.needs_hardware else Job
    further: dict[str, Any] = {}
    if feature.kind.asks_operator:
        further["question"] = (
            str | None,
            Field(description="What the operator has to do before it goes on; null: nothing."),
        )
    if feature.kind.shows_pause:
        text = "It rests at a safe point with outputs off, or will do so after the shot under way, until it is resumed."
        further["paused"] = (bool, Field(description=text))
    base = shown[feature.request_type, feature.result_type]
    config = example(*feature.kind.examples) if feature.kind.examples else None
    return _model(f"{_pascal(kind)}Job", base, feature.kind.description, feature, further, config)


@cache
def job_list_type(kind: str) -> type[ListPage[Any]]:
    """Model of a page of the list of jobs of that kind."""
    feature = feature_of(kind)
    config = example(feature.kind.examples[0], listed=True) if feature.kind.examples else None
    base = ListPage[job_type(kind)]  # type: ignore[misc, valid-type]
    text = f"All {feature.kind.plural}, oldest first."
    return _class(f"{_pascal(kind)}Jobs", base, text, {}, config)


@cache
def request_adapter(kind: str) -> TypeAdapter[Any]:
    """Reads and writes requests of that kind as JSON."""
    return TypeAdapter(feature_of(kind).request_type)


def _model(
    name: str, base: Any, text: str, feature: Feature, further: dict[str, Any] | None = None, config: Any = None
) -> Any:
    kind = (Literal[feature.kind.name], Field(description=f"{feature.kind.article}."))
    return _class(name, base, text, {"kind": kind, **(further or {})}, config)


def _class(name: str, base: type[Schema] | Any, text: str, fields: dict[str, Any], config: Any) -> Any:
    """A subclass of `base`: `create_model` takes either a base or a configuration, not both."""
    names: dict[str, Any] = {"__doc__": text, "__module__": __name__, "__annotations__": {}}
    for field, (annotation, default) in fields.items():
        names["__annotations__"][field], names[field] = annotation, default
    if config is not None:
        names["model_config"] = ConfigDict(json_schema_extra=config)
    return types.new_class(name, (base,), {}, lambda made: made.update(names))


def _pascal(kind: str) -> str:
    return "".join(part.capitalize() for part in kind.split("_"))
