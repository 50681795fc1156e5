"""The bounds of each kind of work, and how an operator changes them (`--worker-limit`)."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache

from drivers.errors import InputError
from platform_daemon.core.registry import job_features

from .bounds import Bounds

# Measured: a diagnosis of 12 shots of 15 s with an exponential drift holds 1.3 GB, 100 shots fitted 1.2 GB; address
# space is more than what is held, by the threads' stacks and arenas.
_OF_NO_KIND_OF_JOB: Mapping[str, Bounds] = {
    "preview": Bounds(4_000, 60.0),
    "series-fit": Bounds(4_000, 600.0),
    "planning": Bounds(4_000, 60.0),
}
_LIMIT = re.compile(r"(?P<kind>[a-z-]+):(?P<number>[0-9]+(\.[0-9]+)?)(?P<unit>MB|s)")
_LEAST_MB = 1000  # the libraries alone


@cache
def default_bounds() -> Mapping[str, Bounds]:
    """The bounds by kind of work: of the jobs as the registry declares them, and of what belongs to no kind of job."""
    kinds = (each.kind for each in job_features())
    of_jobs = {kind.name: Bounds(kind.worker_memory_mb, kind.worker_time_s) for kind in kinds if kind.worker_memory_mb}
    return {**of_jobs, **_OF_NO_KIND_OF_JOB}


@dataclass(frozen=True)
class WorkerLimits:
    """Bounds by kind of work.

    Example: `WorkerLimits().changed(["fit:600s"]).of("fit").time_s` is 600.0.
    """

    by_kind: Mapping[str, Bounds] = field(default_factory=default_bounds)

    def of(self, kind: str) -> Bounds:
        """The bounds of a kind of work.  Raises KeyError for an unknown kind."""
        return self.by_kind[kind]

    def changed(self, limits: Iterable[str]) -> WorkerLimits:
        """A copy in which limits like `diagnosis:8000MB` and `fit:600s` replace those of their kind.

        Raises InputError.
        """
        found = dict(self.by_kind)
        for text in limits:
            match = _LIMIT.fullmatch(text)
            if match is None or match["kind"] not in found:
                raise _bad(text, "it is no KIND:NUMBERMB nor KIND:NUMBERs")
            number, kind = float(match["number"]), match["kind"]
            if match["unit"] == "MB":
                if number < _LEAST_MB:
                    raise _bad(text, f"the libraries alone need {_LEAST_MB} MB")
                found[kind] = replace(found[kind], memory_mb=int(number))
            elif number <= 0:
                raise _bad(text, "nothing is done in no time")
            else:
                found[kind] = replace(found[kind], time_s=number)
        return WorkerLimits(found)


def _bad(text: str, why: str) -> InputError:
    remedy = f"say it as diagnosis:8000MB or fit:600s; kinds: {', '.join(default_bounds())}"
    return InputError(f"{text!r} is no limit of a worker", where="--worker-limit", why=why, remedy=remedy)
