"""Reads the TOML files and hands each room its own section.

Files are named by path, or by the name of one that ships in `config/` (`thread` for `config/resonators/thread.toml`).
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from drivers.errors import ConfigError, InputError
from drivers.registry import PlatformSection
from drivers.specimen import Specimen
from drivers.text_files import read_text_file
from drivers.uncertainty import DeclaredUncertainty
from drivers.validation import validated
from sequences.limits import SafetyLimits
from sequences.request import SequenceRequest

from .schemas.requests import SelfTestOptions


@dataclass(frozen=True)
class PlatformFile:
    """A platform file taken apart: what the registry builds from, the safety envelope, and the text for the record.

    calibration_file: a recording or calibration file that replaces the back end's calibration, None: there is none;
    transmit_file: the same for field and inductance of the coils; self_test: what comes before each series;
    uncertainty: how well influences are known, which budgets read from the text in the recordings.
    """

    path: Path
    text: str
    section: PlatformSection
    limits: SafetyLimits
    calibration_file: Path | None
    transmit_file: Path | None
    self_test: SelfTestOptions
    uncertainty: DeclaredUncertainty


def locate(kind: str, name: str | Path) -> Path:
    """Path of a configuration file: the shipped one of that name, else `name` itself if it is a file or ends in .toml.

    kind: "platforms", "resonators" or "sequences".  Raises ConfigError that lists what ships.
    """
    names = shipped(kind)
    if str(name) in names:
        return names[str(name)]
    path = Path(name)
    if path.suffix == ".toml" or path.is_file():
        return path
    raise ConfigError(
        f"no {kind[:-1]} {str(name)!r}", remedy=f"give the path of a TOML file, or one of: {', '.join(names)}"
    )


def shipped(kind: str) -> dict[str, Path]:
    """The files of a kind that come with the daemon, by name."""
    folder = Path(str(files("config"))) / kind
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def read_toml(path: Path) -> tuple[dict[str, Any], str]:
    """The tables and the text of a TOML file.  Raises ConfigError if it is missing, unreadable or not TOML."""
    try:
        text = read_text_file(path)
        return tomllib.loads(text), text
    except OSError as error:
        why = error.strerror or str(error)
        raise ConfigError("cannot be read", where=str(path), why=why, remedy="check the path") from None
    except (ValueError, RecursionError) as error:
        raise ConfigError("is not TOML", where=str(path), why=str(error), remedy="correct the line named") from None


def load_platform(name: str | Path, overrides: Sequence[str] = (), endpoints: Path | None = None) -> PlatformFile:
    """A platform file, with `KEY=VALUE` overrides (dotted keys, TOML values) applied and `${...}` taken from the file
    `endpoints`.  Raises ConfigError."""
    path = locate("platforms", name)
    try:
        return _load_platform(path, overrides, endpoints)
    except ConfigError as error:
        culprit = _culprit(path, overrides, endpoints)
        if culprit is None or error.where.startswith("--set"):
            raise
        remedy = "correct KEY=VALUE of the option; the platform file itself is right"
        where = f"--set {culprit}, which changes {error.where}"
        raise ConfigError(error.what, where=where, why=error.why, remedy=remedy) from None


def _culprit(path: Path, overrides: Sequence[str], endpoints: Path | None) -> str | None:
    """The first override with which a platform file cannot be used; None: it cannot be used without any."""
    for count in range(len(overrides) + 1):
        try:
            _load_platform(path, overrides[:count], endpoints)
        except ConfigError:
            return overrides[count - 1] if count else None
    return None


def _load_platform(path: Path, overrides: Sequence[str], endpoints: Path | None) -> PlatformFile:
    """See load_platform."""
    tables, text = read_toml(path)
    for override in overrides:
        apply_override(tables, override)
    where = str(path)
    tables = with_endpoints(tables, endpoints)
    calibration = _file_of(tables, "calibration", path)
    transmit = _file_of(tables, "transmit_calibration", path)
    if "limits" not in tables:
        remedy = "add [limits], see docs/reference/configuration.md"
        raise ConfigError("table 'limits' is missing", where=where, remedy=remedy)
    limits = validated(SafetyLimits, _table(tables.pop("limits"), f"{where}: limits"), f"{where}: limits")
    test = validated(SelfTestOptions, _table(tables.pop("self_test", {}), f"{where}: self_test"), f"{where}: self_test")
    known = _table(tables.pop("uncertainty", {}), f"{where}: uncertainty")
    uncertainty = validated(DeclaredUncertainty, known, f"{where}: uncertainty")
    section = validated(PlatformSection, tables, where)
    note = "".join(f"# override: {o}\n" for o in overrides)
    return PlatformFile(path, note + text, section, limits, calibration, transmit, test, uncertainty)


def _file_of(tables: dict[str, Any], name: str, path: Path) -> Path | None:
    """`[name] file = "..."`, relative to the platform file; taken out of the tables."""
    table = tables.get(name)
    if not isinstance(table, dict) or "file" not in table:
        return None
    if set(table) != {"file"} or not isinstance(table["file"], str):
        remedy = "give either file = 'path' or a back end"
        raise ConfigError("key 'file' must be a path and stand alone", where=f"{path}: {name}", remedy=remedy)
    del tables[name]
    return path.parent / table["file"]


def _table(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ConfigError("must be a table", where=where, remedy="write it as [name]")
    return value


def apply_override(tables: dict[str, Any], override: str) -> None:
    """Set one dotted key: `backends.simulated.seed=7`.  Raises ConfigError if it is not KEY=VALUE in TOML."""
    key, _, value = override.partition("=")
    try:
        parsed = tomllib.loads(f"value = {value}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        remedy = "write KEY=VALUE with a TOML value, text in quotes"
        raise ConfigError("cannot be read", where=f"--set {override}", why=str(error), remedy=remedy) from None
    *parents, last = key.strip().split(".")
    for name in parents:
        tables = _table(tables.setdefault(name, {}), f"--set {key}")
    tables[last] = parsed


def real_time_overrides(name: str | Path) -> tuple[str, ...]:
    """Overrides by which the simulated time of a platform passes as that of this computer.

    Raises InputError for a platform whose devices have no simulated time, ConfigError.
    """
    path = locate("platforms", name)
    backends = _table(read_toml(path)[0].get("backends", {}), f"{path}: backends")
    simulated = [backend for backend, options in backends.items() if isinstance(options, dict) and "clock" in options]
    if not simulated:
        remedy = "leave --real-time out: real devices have no other time"
        raise InputError(f"platform {path.stem} has no simulated time", where="--real-time", remedy=remedy)
    return tuple(f'backends.{each}.clock.mode="realtime"' for each in simulated)


def load_specimen(name: str | Path) -> tuple[Specimen, str]:
    """A resonator file and its text.  Raises ConfigError."""
    path = locate("resonators", name)
    tables, text = read_toml(path)
    return validated(Specimen, tables, str(path)), text


def load_sequence(name: str | Path) -> SequenceRequest:
    """A sequence file.  Raises ConfigError."""
    path = locate("sequences", name)
    return validated(SequenceRequest, read_toml(path)[0], str(path))


def refuse_foreign_preset(path: Path, specimen: Specimen, where: str, remedy: str) -> None:
    """Raises InputError for the preset that ships for the other bearing: its field is wrong for this resonator."""
    if path in shipped("sequences").values() and path.stem != specimen.variant:
        why = f"it is the preset of the {path.stem} bearing, {specimen.name!r} has a {specimen.variant} bearing"
        raise InputError("this preset is for another resonator", where=where, why=why, remedy=remedy)


REFERENCE = re.compile(r"\$\{([\w.-]+)\}")
REMEDY = "start `platform-daemon emulate --config FILE --json F` and give --endpoints F"


def with_endpoints(tables: dict[str, Any], endpoints: Path | None) -> dict[str, Any]:
    """The tables with every text that is a reference replaced by its value.

    Raises ConfigError if there are references and no file, or if one refers to nothing.
    """
    known = None if endpoints is None else _read(endpoints)
    return {key: _replaced(value, known, key) for key, value in tables.items()}


def _replaced(value: Any, known: Any, where: str) -> Any:
    if isinstance(value, dict):
        return {key: _replaced(inner, known, f"{where}.{key}") for key, inner in value.items()}
    if isinstance(value, list):
        return [_replaced(inner, known, f"{where}.{k}") for k, inner in enumerate(value)]
    found = REFERENCE.fullmatch(value) if isinstance(value, str) else None
    return value if found is None else _looked_up(found[1], known, where)


def _looked_up(path: str, known: Any, where: str) -> Any:
    if known is None:
        raise ConfigError(f"{path!r} is an endpoint, and no file of endpoints was given", where=where, remedy=REMEDY)
    found = known
    for part in path.split("."):
        try:
            found = found[int(part)] if isinstance(found, list) else found[part]
        except (KeyError, IndexError, TypeError, ValueError):
            raise ConfigError(f"there is no endpoint {path!r}", where=where, remedy=REMEDY) from None
    return found


def _read(path: Path) -> Any:
    try:
        return json.loads(read_text_file(path))
    except OSError as error:
        why = error.strerror or str(error)
        raise ConfigError("the endpoints cannot be read", where=str(path), why=why, remedy=REMEDY) from None
    except (ValueError, RecursionError) as error:
        raise ConfigError("the endpoints are not JSON", where=str(path), why=str(error), remedy=REMEDY) from None
