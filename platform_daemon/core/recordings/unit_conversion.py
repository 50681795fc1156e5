"""Units as files write them, and what a number in one of them is in another.

A small table serves better than a library of units: files hold a dozen units with SI prefixes, an unknown one must be
refused by its name, and text of a file must not be evaluated as an expression.

A unit is a product: `u = s_1^k_1 s_2^k_2 ...`, written with blanks, `*`, `.` or `/` between its symbols and exponents
as in `A m^2/s`, `A.m2.s-1` or `V/(A m²/s)`.  Each symbol is a factor times powers of kg, m, s, A and rad, so one unit
converts to another if these powers are equal.  Only temperatures have an offset.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

Powers = tuple[int, ...]
"""Exponents of kg, m, s, A, rad."""


class Conversion(NamedTuple):
    """`wanted = factor * found + offset`."""

    factor: float = 1.0
    offset: float = 0.0


_ONE: Powers = (0, 0, 0, 0, 0)
_PREFIXED: dict[str, tuple[float, Powers]] = {
    "g": (1e-3, (1, 0, 0, 0, 0)),
    "m": (1.0, (0, 1, 0, 0, 0)),
    "s": (1.0, (0, 0, 1, 0, 0)),
    "A": (1.0, (0, 0, 0, 1, 0)),
    "rad": (1.0, (0, 0, 0, 0, 1)),
    "Hz": (1.0, (0, 0, -1, 0, 0)),
    "N": (1.0, (1, 1, -2, 0, 0)),
    "J": (1.0, (1, 2, -2, 0, 0)),
    "V": (1.0, (1, 2, -3, -1, 0)),
    "H": (1.0, (1, 2, -2, -2, 0)),
    "Wb": (1.0, (1, 2, -2, -1, 0)),
    "T": (1.0, (1, 0, -2, -1, 0)),
    "G": (1e-4, (1, 0, -2, -1, 0)),
}
_SYMBOLS: dict[str, tuple[float, Powers]] = {
    "min": (60.0, (0, 0, 1, 0, 0)),
    "h": (3600.0, (0, 0, 1, 0, 0)),
    "d": (86400.0, (0, 0, 1, 0, 0)),
    "deg": (math.pi / 180.0, (0, 0, 0, 0, 1)),
    "°": (math.pi / 180.0, (0, 0, 0, 0, 1)),
    "turn": (2.0 * math.pi, (0, 0, 0, 0, 1)),
    "%": (1e-2, _ONE),
    **dict.fromkeys(("1", "counts", "count", "samples", "sample", "dimensionless"), (1.0, _ONE)),
}
_PREFIXES = {"": 1.0, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}
_PREFIX_NAMES = {"nano": "n", "micro": "u", "milli": "m", "kilo": "k", "mega": "M", "giga": "G"}
_NAMES = {
    **dict.fromkeys(("second", "sec"), "s"),
    **dict.fromkeys(("hertz", "hz"), "Hz"),
    **dict.fromkeys(("volt", "v"), "V"),
    **dict.fromkeys(("ampere", "amp"), "A"),
    **dict.fromkeys(("meter", "metre"), "m"),
    "tesla": "T",
    "gauss": "G",
    "henry": "H",
    **dict.fromkeys(("radian", "rad"), "rad"),
    **dict.fromkeys(("degree", "deg"), "deg"),
    **dict.fromkeys(("minute", "min"), "min"),
    **dict.fromkeys(("hour", "hr"), "h"),
    "day": "d",
    **dict.fromkeys(("turn", "revolution"), "turn"),
    "khz": "kHz",
}
"""By name in small letters, with or without the s of a plural."""
_KELVIN = {  # degC = factor * found + offset
    **dict.fromkeys(("degc", "°c", "deg_c", "celsius", "degree_celsius", "degrees_celsius", "c"), Conversion()),
    **dict.fromkeys(("k", "kelvin"), Conversion(offset=-273.15)),
    **dict.fromkeys(("degf", "°f", "fahrenheit"), Conversion(5.0 / 9.0, -160.0 / 9.0)),
}
_SPELLING = str.maketrans({"µ": "u", "μ": "u", "·": "*", "⋅": "*", "×": "*", "²": "2", "³": "3"})
_TOKEN = re.compile(r"\s*(?:([A-Za-z_°%]+|1(?!\d))(?:(?:\^|\*\*)?([+-]?[1-9])(?!\d))?|(\*|\.|/|\(|\)))\s*")
_MOST_CHARACTERS = 100
_Token = tuple[str | None, str | None, str | None]
"""Symbol, its exponent, and a mark between symbols."""


def conversion(found: str, wanted: str) -> Conversion | None:
    """How a number in the unit `found` becomes one in `wanted`; None if that is unknown or of another dimension.

    wanted: one of our own units; a `found` without dimension is also taken for rad.
    """
    if wanted == "degC":
        return _KELVIN.get(found.strip().lower())
    seen, target = _parsed(found), _parsed(wanted)
    if seen is None or target is None:
        return None
    (factor, powers), (one, expected) = seen, target
    if powers != expected and not (powers == _ONE and wanted == "rad"):
        return None
    short = float(f"{factor / one:.6g}")  # 1e-3 / 1e-9 is 1000000.0000000001
    return Conversion(short if math.isclose(short, factor / one, rel_tol=1e-15) else factor / one)


def is_unit(text: str) -> bool:
    """Is it a unit that is known here?"""
    return bool(text.strip()) and (_parsed(text) is not None or text.strip().lower() in _KELVIN)


def is_dimensionless(text: str) -> bool:
    """Is it a unit of a plain number, as `%` and `counts`?"""
    found = _parsed(text)
    return found is not None and found[1] == _ONE


def _parsed(text: str) -> tuple[float, Powers] | None:
    """(factor, powers) of a unit; None if it is none."""
    text = text.strip().translate(_SPELLING)
    if not text:
        return 1.0, _ONE
    tokens: list[_Token] = []
    at = 0
    while at < len(text) <= _MOST_CHARACTERS:
        match = _TOKEN.match(text, at)
        if match is None:
            return None
        tokens.append((match[1], match[2], match[3]))
        at = match.end()
    return _product(tokens) if tokens else None


def _product(tokens: list[_Token]) -> tuple[float, Powers] | None:
    """Factors from left to right; after `/` the next symbol, or what is in brackets, is divided by."""
    factor, powers = 1.0, _ONE
    signs, sign, complete = [1], 1, False  # signs: of each open bracket; complete: a symbol stands before
    for symbol, exponent, mark in tokens:
        if symbol is not None:
            known = _symbol(symbol)
            if known is None:
                return None
            k = sign * signs[-1] * int(exponent or 1)
            factor *= known[0] ** k
            powers = tuple(p + k * q for p, q in zip(powers, known[1], strict=True))
            sign, complete = 1, True
        elif mark == "(":
            signs.append(sign * signs[-1])
            sign, complete = 1, False
        elif not complete or (mark == ")" and len(signs) == 1):
            return None
        elif mark == ")":
            signs.pop()
        else:
            sign, complete = -1 if mark == "/" else 1, False
    return (factor, powers) if complete and len(signs) == 1 else None


def _symbol(text: str) -> tuple[float, Powers] | None:
    found = _SYMBOLS.get(text) or _prefixed(text)
    if found is not None:
        return found
    word = text.lower()
    prefix = next((name for name in _PREFIX_NAMES if word.startswith(name)), "")
    stem = word.removeprefix(prefix)
    known = _NAMES.get(stem) or _NAMES.get(stem.removesuffix("s"))
    if known is None:
        return None
    plain = _SYMBOLS.get(known) or _prefixed(known)
    return None if plain is None else (plain[0] * _PREFIXES[_PREFIX_NAMES.get(prefix, "")], plain[1])


def _prefixed(text: str) -> tuple[float, Powers] | None:
    for symbol, (factor, powers) in _PREFIXED.items():
        scale = _PREFIXES.get(text.removesuffix(symbol)) if text.endswith(symbol) else None
        if scale is not None and not (symbol == "rad" and scale > 1.0):  # Grad are degrees or gons, and no giga-radians
            return scale * factor, powers
    return None
