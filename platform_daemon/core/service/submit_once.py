"""Submissions with an idempotency key: a repeated one returns the job of the first, also after a restart.

The id of such a job ends with digests of the key and of the request.  So the key is on the disk from the moment on at
which the job is, by the same write, and is found for as long as the job is.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime
from hashlib import sha256
from typing import Any

from drivers.errors import InputError
from platform_daemon.core.jobs.jobs import new_identifier

from .job_view import JobView
from .platform_service import JobService

MOST_KEY = 200
"""Longest idempotency key, in characters."""
_KEY_DIGITS, _REQUEST_DIGITS = 16, 8
_LOCKS = 32


class IdempotencyKeyReused(InputError):
    """An idempotency key was sent with two different requests; the job of the first one is untouched."""

    title = "Idempotency key reused"


class SubmitOnce:
    """The submissions of one service.  For any number of threads: two with one key wait for each other."""

    def __init__(self) -> None:
        self._locks = [threading.Lock() for _ in range(_LOCKS)]

    def job(self, service: JobService, kind: str, request: Any, key: str, submit: Callable[[str], JobView]) -> JobView:
        """The job of the first submission with that key; submit: makes the job of that id if there is none.

        Raises IdempotencyKeyReused, and what `submit` raises: then a later submission with the key is a first one.
        """
        digest, request_digest = _digest(key, _KEY_DIGITS), _digest(request.model_dump_json(), _REQUEST_DIGITS)
        with self._locks[hash(key) % _LOCKS]:
            for identifier in service.job_ids(kind):
                last = identifier.rpartition("-")[2]
                if len(last) != _KEY_DIGITS + _REQUEST_DIGITS or not last.startswith(digest):
                    continue
                if not last.endswith(request_digest):
                    raise IdempotencyKeyReused(
                        "the idempotency key was sent before with another request",
                        where="Idempotency-Key",
                        why=f"it belongs to {identifier}",
                        remedy="send a new key with a new request, or the first request again",
                    )
                return service.job(kind, identifier)
            return submit(new_identifier(kind, datetime.now(UTC), digest + request_digest))


def _digest(text: str, digits: int) -> str:
    return sha256(text.encode()).hexdigest()[:digits]
