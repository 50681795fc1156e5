"""The keys that a sweep may vary: those of an acquisition, nested by dots, and their short names."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import BaseModel

from drivers.errors import InputError
from drivers.validation import validated
from platform_daemon.core.schemas.requests import AcquisitionRequest

ONE_PER_RECORDING = ("resonator", "sample", "operator", "comment")
"""What a recording can say once only."""
NO_SINGLE_VALUE = ("shot_changes", "plan_parameters")
"""What holds several values by itself."""
OF_THE_PROCEDURE = ("priority",)
"""What all its steps have from it."""
_UNITS = {"_t": {"_ut": 1e6, "_mt": 1e3}, "_s": {"_ms": 1e3}, "_hz": {"_khz": 1e-3}, "_rad": {"_deg": 180 / math.pi}}
"""By the ending of a key: endings that people use, and how many of their unit make one of the key's."""


@dataclass(frozen=True)
class SweepKey:
    """Place of a key in an acquisition; per_unit: the given value is divided by this, None: unchanged."""

    path: tuple[str, ...]
    per_unit: float | None = None

    def value(self, given_value: Any) -> Any:
        """In the unit of the acquisition."""
        scaled = self.per_unit is not None and isinstance(given_value, int | float)
        return given_value / self.per_unit if scaled else given_value


@cache
def keys_of(model: type[BaseModel]) -> dict[str, SweepKey]:
    """Every key of a request, by each of its names: nested by dots, its own, and those in people's units.

    A key of the request itself goes before one of the same name further inside.
    """
    paths = sorted(_paths(model, ()), key=len)
    found = {".".join(path): SweepKey(path) for path in paths}
    found |= {key.path[-1]: key for key in list(found.values()) if key.path[-1] not in found}
    for name, key in list(found.items()):
        for ending, others in _UNITS.items():
            if name.endswith(ending):
                stem = name.removesuffix(ending)
                found |= {f"{stem}{other}": SweepKey(key.path, per_unit) for other, per_unit in others.items()}
    return found


@cache
def sweep_keys() -> dict[str, SweepKey]:
    """Every key that can be swept, by each of its names; the first name is that in the acquisition."""
    never = (*ONE_PER_RECORDING, *NO_SINGLE_VALUE, *OF_THE_PROCEDURE)
    return {name: key for name, key in keys_of(AcquisitionRequest).items() if key.path[-1] not in never}


def _paths(model: type[BaseModel], above: tuple[str, ...]) -> list[tuple[str, ...]]:
    paths = []
    for name, field in model.model_fields.items():
        inner = field.annotation
        nested = isinstance(inner, type) and issubclass(inner, BaseModel)
        paths += _paths(inner, (*above, name)) if nested else [(*above, name)]  # type: ignore[arg-type]
    return paths


def sweep_key(name: str) -> SweepKey:
    """The key of that name.  Raises InputError that names the keys that exist."""
    found = sweep_keys().get(name)
    if found is not None:
        return found
    if name in ONE_PER_RECORDING:
        why, remedy = f"a recording has one {name}", "give it in the acquisition, or make a sweep for each"
        raise InputError(f"{name!r} cannot be swept", where="over", why=why, remedy=remedy)
    full = [known for known, key in sweep_keys().items() if ".".join(key.path) == known]
    remedy = f"one of: {', '.join(full)}; those of sequence also as field_t, field_ut, rx_ms, f_tx_khz"
    raise InputError(f"no key of an acquisition is called {name!r}", where="over", remedy=remedy)


def with_values(request: AcquisitionRequest, values: dict[SweepKey, Any], where: str) -> AcquisitionRequest:
    """The request with other values of these keys.  Raises ConfigError that names `where` for one that cannot be."""
    table: dict[str, Any] = request.model_dump()
    for key, given_value in values.items():
        place = table
        for part in key.path[:-1]:
            place = place[part]
        place[key.path[-1]] = key.value(given_value)
    return validated(AcquisitionRequest, table, where)
