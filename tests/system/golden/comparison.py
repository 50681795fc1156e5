"""Two folders of golden files compared: byte for byte, or so that another computer's rounding may differ."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.system.golden.tolerances import in_any_order, is_close, number_for_nothing

_DECIMAL = re.compile(r"-?\d+\.\d+(?:[eE][+-]?\d+)?|-?\d+[eE][+-]?\d+|[+-]?\d+")

# Frames of tables are as wide as their numbers; the standard deviation in brackets is the last digits of one; a digest
# is of numbers to their last bit.
_FRAME = re.compile(r"[━─]+|(?<=\d)\(\d+\)|(?<=sha256 )[0-9a-f]{12}")


def differences(golden: Path, found: Path, *, exact: bool) -> list[str]:
    """One line per difference: file, JSON pointer, what was and what is."""
    were, are = _files(golden), _files(found)
    lines = [f"{name}: is missing now" for name in were if name not in are]
    lines += [f"{name}: is new" for name in are if name not in were]
    for name in (n for n in were if n in are):
        was, now = were[name].read_text(encoding="utf-8"), are[name].read_text(encoding="utf-8")
        if was != now:
            told = [f"{name}{line}" for line in _compared(name, was, now, exact)]
            lines += told or ([f"{name}: the same values in another text: {_first_change(was, now)}"] if exact else [])
    return lines


def _files(folder: Path) -> dict[str, Path]:
    return {p.relative_to(folder).as_posix(): p for p in sorted(folder.rglob("*")) if p.is_file()}


def _compared(name: str, was: str, now: str, exact: bool) -> Iterator[str]:
    kind = Path(name).suffix
    if kind == ".json" and was.strip() and now.strip():
        yield from (f"#{line}" for line in values(json.loads(was), json.loads(now), exact=exact))
        return
    old, new = was.splitlines(), now.splitlines()
    if len(old) != len(new):
        yield f": {len(old)} lines were, {len(new)} lines are"
    for number, (a, b) in enumerate(zip(old, new, strict=False), 1):
        if kind == ".jsonl":
            yield from (f":{number}#{line}" for line in values(json.loads(a), json.loads(b), exact=exact))
        elif a != b and (exact or not same_words(a, b)):
            yield f":{number}: was {a!r}, is {b!r}"


def _first_change(was: str, now: str) -> str:
    place = next((k for k, (a, b) in enumerate(zip(was, now, strict=False)) if a != b), min(len(was), len(now)))
    start = max(0, place - 20)
    return f"at character {place}: was {was[start : place + 30]!r}, is {now[start : place + 30]!r}"


def values(was: Any, now: Any, pointer: str = "", *, exact: bool = False, std: float = 0.0) -> Iterator[str]:
    """Differences of two JSON values, as `pointer: what`; the order of keys counts.  std: see `is_close`."""
    if not exact:
        was, now = number_for_nothing(was, pointer), number_for_nothing(now, pointer)
    if type(was) is not type(now):
        yield f"{pointer}: was {_short(was)}, is {_short(now)}"
    elif isinstance(was, dict):
        yield from _objects(was, now, pointer, exact)
    elif isinstance(was, list):
        yield from _lists(was, now, pointer, exact)
    elif was != now and (exact or not (is_close(was, now, pointer, std) or _same_text(was, now))):
        yield f"{pointer}: was {_short(was)}, is {_short(now)}"


def _lists(was: list[Any], now: list[Any], pointer: str, exact: bool) -> Iterator[str]:
    if len(was) != len(now):
        yield f"{pointer}: {len(was)} entries were, {len(now)} are"
    elif not exact:
        was, now = in_any_order(was, pointer), in_any_order(now, pointer)
    for k, (a, b) in enumerate(zip(was, now, strict=False)):
        yield from values(a, b, f"{pointer}/{k}", exact=exact)


def _objects(was: dict[str, Any], now: dict[str, Any], pointer: str, exact: bool) -> Iterator[str]:
    if list(was) != list(now):
        lost, added = [k for k in was if k not in now], [k for k in now if k not in was]
        yield f"{pointer}: keys lost {lost}, new {added}" if lost or added else f"{pointer}: the order of keys changed"
    std = was.get("std")
    for key in (k for k in was if k in now):
        name = key.replace("~", "~0").replace("/", "~1")
        spread = std if isinstance(std, float) and key in ("value", "mean") else 0.0
        yield from values(was[key], now[key], f"{pointer}/{name}", exact=exact, std=spread)


def _same_text(was: Any, now: Any) -> bool:
    return isinstance(was, str) and same_words(was, now)


def same_words(was: str, now: str) -> bool:
    """The same text, but that the last digit of a rounded number may differ by two: it may be near a half."""
    was, now = _FRAME.sub(" ", was), _FRAME.sub(" ", now)
    old, new = _DECIMAL.findall(was), _DECIMAL.findall(now)
    if _DECIMAL.sub("#", was).split() != _DECIMAL.sub("#", now).split() or len(old) != len(new):
        return False
    return all(a == b or abs(float(a) - float(b)) <= 2.01 * _last_digit(a) for a, b in zip(old, new, strict=True))


def _last_digit(number: str) -> float:
    digits, _, exponent = number.lower().partition("e")
    decimals = len(digits.partition(".")[2])
    return 0.0 if not decimals and not exponent else 10.0 ** (int(exponent or 0) - decimals)


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) < 100 else f"{text[:97]}..."
