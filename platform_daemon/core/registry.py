"""The registry of features: what each one offers, as names of modules that are imported when they are needed.

Core names no feature.  `platform_daemon.features.registry` lists the folders; each folder's `__init__.py` holds one
`FEATURE`, which imports nothing but this module.  So the hardware process loads a feature's `work` and never its
`routes`, `report` or `command`.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, Union

from drivers.errors import InputError

_REGISTRY = "platform_daemon.features.registry"


@dataclass(frozen=True, kw_only=True)
class JobKind:
    """A kind of job.  Places are "module:name"; a module that begins with a dot is one of the feature's folder.

    Attributes:
        name: kind of its jobs, as in their ids: "calibration".
        plural: segment of its REST paths: "calibrations".
        request: model of its requests, a `QueuedRequest` if it needs the hardware, else a `Request`.
        result: model of what comes out.
        grows: True if `result` is there, and grows, from the start; False: it is empty (`NoResult`) until the end.
        plan: function (bench, request) -> Work, which checks the request; nothing moves.
        summary: model of a dry run's answer, with `dry_run`, a function (bench, request) -> summary; "": it has none.
        scheduled: model of a schedule's work of this kind; "": {"kind", "request"}.
        needs_hardware: True if its jobs wait for the platform; False: they run in the web process's workers.
        asks_operator: True if a job may wait for a person.
        shows_pause: True if its jobs say whether they are paused, or will be at their next safe point.
        submits_steps: True if its jobs move nothing themselves, but submit others that do, one after the other.
        resumable: True if POST .../resume makes what is missing of a job that was cut off.
        worker_memory_mb, worker_time_s: bounds of the worker process that computes for its jobs; 0: none does.
        description: one sentence for the model of its jobs; article: "A self-test", how one is called.
        examples: names of the examples of a job in core/schemas/examples.
        title, about, got, cancelled: what the standard routes say of POST (summary and description), GET and DELETE.
        plans_on_a_core: True if planning a request takes as long as a computation.
    """

    name: str
    plural: str
    request: str
    result: str
    plan: str
    description: str
    article: str
    title: str = "Start"
    about: str = "Queue a job, which waits its turn."
    got: str = "State and progress, and what came out."
    cancelled: str = "Cancel.  It ends within 0.1 s with outputs off."
    grows: bool = False
    dry_run: str = ""
    summary: str = ""
    scheduled: str = ""
    needs_hardware: bool = True
    asks_operator: bool = False
    shows_pause: bool = False
    submits_steps: bool = False
    resumable: bool = False
    worker_memory_mb: int = 0
    worker_time_s: float = 0.0
    plans_on_a_core: bool = False
    examples: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Procedure:
    """A kind of procedure: a job that submits one series after the other.

    Attributes:
        name: kind of procedure, as in the requests: "ramp".
        request, outcome: models; outcome "": it has no result besides those of its steps.
        plan: function (bench, request) -> ProcedureWork, which checks every known step; nothing moves.
    """

    name: str
    request: str
    plan: str
    outcome: str = ""


@dataclass(frozen=True, kw_only=True)
class Command:
    """A command of the command line.

    Attributes:
        name: as it is typed.
        module, attribute: where the function or the `typer.Typer` is, the module relative to the feature's folder.
        help: the first paragraph of its help, for the list of commands.
    """

    name: str
    attribute: str
    help: str
    module: str = ".command"


@dataclass(frozen=True, kw_only=True)
class Feature:
    """What a folder below `platform_daemon/features` offers.

    Attributes:
        job: its kind of job, None: it has none.
        procedure: its kind of procedure, None: it has none.
        routes: modules with a `router`, in the order of the documentation; () with a job: the standard routes.
        commands: its commands of the command line.
        tag: group of its routes in the documentation, with its description.
        service: contract of what it offers in the hardware process, a Protocol; "": nothing.
        errors: modules whose errors must be known wherever a problem is read or explained.
        package: full name of the folder; filled in by the registry.
    """

    job: JobKind | None = None
    procedure: Procedure | None = None
    routes: tuple[str, ...] = ()
    tag: tuple[str, str] | None = None
    commands: tuple[Command, ...] = ()
    errors: tuple[str, ...] = ()
    service: str = ""
    package: str = ""

    def load(self, place: str) -> Any:
        """What stands at "module:name" of this feature, or the module at "module"."""
        module, _, name = place.partition(":")
        found = importlib.import_module(module, self.package)
        return getattr(found, name) if name else found

    @cached_property
    def request_type(self) -> Any:
        """Model of the requests of its job."""
        return self.load(self.kind.request)

    @cached_property
    def result_type(self) -> Any:
        """Model of the results of its job, from the first moment on."""
        from .schemas.base import NoResult

        result = self.load(self.kind.result)
        return result if self.kind.grows else Union[result, NoResult]  # noqa: UP007 made at run time

    @property
    def kind(self) -> JobKind:
        """Its kind of job.  Raises LookupError if it has none."""
        if self.job is None:
            raise LookupError(f"{self.package} has no job")
        return self.job


@cache
def features() -> tuple[Feature, ...]:
    """All features, in the order of the registry."""
    names = importlib.import_module(_REGISTRY).FEATURES
    packages = [importlib.import_module(f"platform_daemon.features.{name}") for name in names]
    return tuple(replace(each.FEATURE, package=each.__name__) for each in packages)


def job_features() -> Iterator[Feature]:
    """Those that have a kind of job."""
    return (each for each in features() if each.job is not None)


def procedures() -> Iterator[tuple[Feature, Procedure]]:
    """Those that have a kind of procedure."""
    return ((each, each.procedure) for each in features() if each.procedure is not None)


@cache
def _by_kind() -> dict[str, Feature]:
    return {each.kind.name: each for each in job_features()}


def feature_of(kind: str) -> Feature:
    """The feature whose jobs are of that kind.  Raises InputError."""
    found = _by_kind().get(kind)
    if found is None:
        raise InputError(f"no job is of the kind {kind!r}", where="kind", remedy=f"one of: {', '.join(_by_kind())}")
    return found


def kinds(*, on_hardware: bool) -> frozenset[str]:
    """Kinds of jobs that need the hardware, or of those that do not."""
    return frozenset(each.kind.name for each in job_features() if each.kind.needs_hardware is on_hardware)


@cache
def kinds_that_submit_steps() -> frozenset[str]:
    """Kinds of jobs that move nothing themselves, but submit others that do."""
    return frozenset(each.kind.name for each in job_features() if each.kind.submits_steps)


def load_errors() -> None:
    """Import every module whose errors a process must know by the names of their classes."""
    for each in features():
        for module in each.errors:
            each.load(module)
