"""What each kind of work may take, and how an operator changes it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from drivers.errors import InputError

from .bounds import Bounds

# Measured: a diagnosis of 12 shots of 15 s with an exponential drift holds 1.3 GB, 100 shots fitted 1.2 GB; address
# space is more than what is held, by the threads' stacks and arenas.
DEFAULTS: Mapping[str, Bounds] = {
    "fit": Bounds(8_000, 3600.0),
    "diagnosis": Bounds(12_000, 2 * 3600.0),
    "characterisation": Bounds(8_000, 2 * 3600.0),
    "preview": Bounds(4_000, 60.0),
    "series-fit": Bounds(4_000, 120.0),
    "planning": Bounds(4_000, 60.0),
    "procedure": Bounds(8_000, 3600.0),
}
_LIMIT = re.compile(r"(?P<kind>[a-z-]+):(?P<number>[0-9]+(\.[0-9]+)?)(?P<unit>MB|s)")
_LEAST_MB = 1000  # the libraries alone


@dataclass(frozen=True)
class WorkerLimits:
    """Bounds by kind of work."""

    by_kind: Mapping[str, Bounds] = field(default_factory=lambda: DEFAULTS)

    def of(self, kind: str) -> Bounds:
        """Those of a kind."""
        return self.by_kind[kind]

    def changed(self, asked: Iterable[str]) -> WorkerLimits:
        """With limits like `diagnosis:8000MB` and `fit:600s` in the place of those there are.  Raises InputError."""
        found = dict(self.by_kind)
        for text in asked:
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
    remedy = f"say it as diagnosis:8000MB or fit:600s; kinds: {', '.join(DEFAULTS)}"
    return InputError(f"{text!r} is no limit of a worker", where="--worker-limit", why=why, remedy=remedy)
