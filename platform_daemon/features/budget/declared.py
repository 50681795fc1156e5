"""What a recording declares about the influences: of its configuration, `[uncertainty]` alone."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from drivers.errors import InputError, RecordingError
from drivers.uncertainty import DeclaredUncertainty
from drivers.validation import validated
from platform_daemon.core.recordings.recording import RESONATOR, Recording
from platform_daemon.core.schemas.parameters import PARAMETERS
from platform_daemon.core.settings import apply_override, read_toml

_OVERRIDE = "# override: "


def declared_in(recording: Recording) -> DeclaredUncertainty:
    """Of the platform, and in its place what the resonator's file says.  Raises RecordingError, ConfigError."""
    text, _, resonator = recording.configuration_toml().partition(RESONATOR)
    where = f"{recording.path}: uncertainty"
    overrides = [
        line.removeprefix(_OVERRIDE) for line in text.splitlines() if line.startswith(f"{_OVERRIDE}uncertainty")
    ]
    platform = _table(text, where)
    for each in overrides:
        apply_override(platform, each)
    told = [validated(DeclaredUncertainty, platform.get("uncertainty", {}), where)]
    told.append(validated(DeclaredUncertainty, _table(resonator, where).get("uncertainty", {}), where))
    return told[0].under(told[1])


def declared_by(path: Path) -> DeclaredUncertainty:
    """Of a TOML file with the keys of `[uncertainty]`, or with that table.  Raises ConfigError."""
    tables, _ = read_toml(path)
    return validated(DeclaredUncertainty, tables.get("uncertainty", tables), str(path))


def check_coefficients(declared: DeclaredUncertainty, names: Sequence[str]) -> None:
    """Raises InputError for a coefficient of what is neither one of these parameters nor one that other models have: it
    would do nothing, and what is declared beside it would be taken in its place."""
    for name in declared.temperature_coefficient_per_k:
        if name not in names and name not in PARAMETERS:
            where, remedy = f"temperature_coefficient_per_k.{name}", f"name one of: {', '.join(names)}"
            raise InputError(f"no fit has a parameter {name!r}", where=where, remedy=remedy)


def _table(text: str, where: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        remedy = "give what is known with --uncertainty FILE"
        raise RecordingError("its configuration is not TOML", where=where, why=str(error), remedy=remedy) from None
