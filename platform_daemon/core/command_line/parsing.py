"""Texts of the command line as values: windows, parameters, frames."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

from drivers.errors import InputError

if TYPE_CHECKING:
    from platform_daemon.core.schemas.base import Window

_PART = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?")
_MOST = 1_000_000
_NAMED_WINDOWS: dict[str, Window] = {"n50": "n50", "d30": "d30"}


def parse_window(text: str) -> Window:
    """ "n50", "d30", also in capital letters as tables have them, or a positive number of s.  Raises InputError."""
    if text.lower() in _NAMED_WINDOWS:
        return _NAMED_WINDOWS[text.lower()]
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not (math.isfinite(seconds) and seconds > 0):
        raise InputError(f"no window {text!r}", where="window", remedy="give n50, d30, or a positive number of seconds")
    return seconds


def parse_values(texts: list[str], option: str) -> dict[str, float] | None:
    """`NAME=VALUE` texts as parameters by name; None if there are none.  Raises InputError that names the option."""
    values: dict[str, float] = {}
    for text in texts:
        name, _, value = text.partition("=")
        check_parameter(name, option)
        try:
            values[name] = float(value)
        except ValueError:
            raise InputError(f"{text!r} holds no number", where=option, remedy="write NAME=VALUE") from None
    return values or None


def check_parameter(name: str, option: str) -> None:
    """Raises InputError that names the option if no parameter is called so."""
    from platform_daemon.core.schemas.parameters import PARAMETERS

    if name in PARAMETERS:
        return
    from platform_daemon.estimation.physics.torques import SEPARATE  # terms of other packages; numba is loaded with it

    known = [*PARAMETERS, *(each.name for term in SEPARATE for each in term.coefficients)]
    if name not in known:
        raise InputError(f"no parameter is called {name!r}", where=option, remedy=f"one of: {', '.join(known)}")


def parse_frames(text: str) -> tuple[int, ...]:
    """ "0,2,5-9" as frame numbers, in order, each once.  Raises InputError."""
    found: set[int] = set()
    for part in text.split(","):
        match = _PART.fullmatch(part.strip())
        first, last = (0, -1) if match is None else (int(match[1]), int(match[2] or match[1]))
        if not first <= last < first + _MOST:
            remedy = "write numbers and ranges with commas, as in 0,2,5-9"
            raise InputError(f"no frames {text!r}", where="--frames", remedy=remedy)
        found.update(range(first, last + 1))
    return tuple(sorted(found))


def parse_axis(text: str) -> str | tuple[float, ...]:
    """x, y, z, or "1,0,0.5" as a direction in world axes.  Raises InputError."""
    if text in ("x", "y", "z"):
        return text
    try:
        direction = tuple(float(part) for part in text.split(","))
    except ValueError:
        direction = ()
    if len(direction) != 3 or not any(direction) or not all(map(math.isfinite, direction)):
        remedy = "give x, y, z, or three numbers with commas, as in 1,0,0.5"
        raise InputError(f"{text!r} is no axis", where="--axis", remedy=remedy)
    return direction


def parse_points(text: str, option: str) -> dict[str, Any]:
    """KEY=FROM:TO:STEP or KEY=A,B,C as a SweepAxis.  Raises InputError that names the option."""
    key, is_there, values = text.partition("=")
    span = [parse_number(part) for part in values.split(":")]
    listed = [part.strip() for part in values.split(",")]
    if key and len(span) == 3 and None not in span:
        return dict(zip(("key", "start", "stop", "step"), (key, *span), strict=True))
    if key and is_there and len(span) == 1 and all(listed):
        return {"key": key, "values": [part if (n := parse_number(part)) is None else n for part in listed]}
    remedy = "write KEY=FROM:TO:STEP, as field_ut=50:300:10, or KEY=A,B,C, as axis=x,y"
    raise InputError(f"{text!r} is no range of a key", where=option, remedy=remedy)


def parse_number(text: str) -> int | float | None:
    """A number as it is written; None: it is none."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return None


def parse_keys(texts: list[str], option: str) -> dict[str, Any]:
    """`KEY=VALUE` texts as a table, keys nested by dots; a value is a number where it reads as one.

    Raises InputError that names the option.
    """
    table: dict[str, Any] = {}
    for text in texts:
        key, is_there, value = text.partition("=")
        place = table
        *above, last = key.strip().split(".")
        for part in above:
            place = place.setdefault(part, {}) if isinstance(place, dict) else {}
        if not is_there or not key or not isinstance(place, dict):
            raise InputError(f"{text!r} is no key with a value", where=option, remedy="write KEY=VALUE")
        number = parse_number(value)
        place[last] = value.strip() if number is None else number
    return table
