"""Work of a kind that nobody has ever heard of, for engines and queues."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field

from platform_daemon.core.jobs.jobs import AnyJob

TIMEOUT_S = 20


@dataclass
class Walk:
    """Work of a kind that the engine has never heard of."""

    do: Callable[[AnyJob], None] = lambda job: None
    begun: threading.Event = field(default_factory=threading.Event)
    kind, request, total, unit, no_result = "walk", "to the corner", 3, "steps", None

    def __call__(self, job: AnyJob) -> None:
        self.begun.set()
        self.do(job)


def ended(job: AnyJob) -> AnyJob:
    assert job.ended.wait(TIMEOUT_S)
    return job
