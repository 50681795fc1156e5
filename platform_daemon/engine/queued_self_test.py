"""A self-test of an engine's platform as a job of its own."""

from __future__ import annotations

from platform_daemon.schemas import SelfTestRequest

from .asked import AS_NOW, Asked
from .engine import Engine
from .work.self_test_work import SelfTestJob, SelfTestWork


def queue_self_test(engine: Engine, request: SelfTestRequest, asked: Asked = AS_NOW) -> SelfTestJob:
    """Behind what waits for the platform.  Raises SequenceRejected and as `Engine.submit`; nothing moves then."""
    return engine.submit(plan_self_test(engine, request), asked=asked)


def plan_self_test(engine: Engine, request: SelfTestRequest) -> SelfTestWork:
    """Its checked work; nothing moves.  Raises SequenceRejected."""
    return SelfTestWork(request, engine.calibration_in_use.requested_self_test)
