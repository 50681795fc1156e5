"""A self-test of an engine's platform as a job of its own."""

from __future__ import annotations

from platform_daemon.schemas import SelfTestRequest

from .engine import Engine
from .jobs import AnyJob
from .work.self_test_work import SelfTestJob, SelfTestWork


def queue_self_test(
    engine: Engine,
    request: SelfTestRequest,
    again: AnyJob | None = None,
    identifier: str | None = None,
    stops: int | None = None,
) -> SelfTestJob:
    """Behind what waits for the platform.  Raises SequenceRejected and as `Engine.submit`; nothing moves then."""
    return engine.submit(plan_self_test(engine, request), None, again, identifier, stops)


def plan_self_test(engine: Engine, request: SelfTestRequest) -> SelfTestWork:
    """Its checked work; nothing moves.  Raises SequenceRejected."""
    return SelfTestWork(request, engine.calibration_in_use.requested_self_test)
