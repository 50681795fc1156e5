"""The complaints of pydantic about a table, in words: which key, what it must be, and what may have been meant.

One place for TOML files, the command line and REST.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from drivers.errors import ConfigError

Model = TypeVar("Model", bound=BaseModel)

_MAX_LISTED = 20  # complaints in one message

_UNITS = {
    **{
        "per_s": "1/s",
        "hz": "Hz",
        "s": "s",
        "t": "T",
        "m": "m",
        "v": "V",
        "a": "A",
        "rad": "rad",
        "c": "°C",
        "db": "dB",
    },
    **{"ohm": "ohm", "h": "H", "am2": "A m^2", "am2_per_s": "A m^2/s", "pa": "Pa"},
}
_MEANT = {"T": (1e-6, "uT"), "s": (1e-3, "ms"), "rad": (math.pi / 180, "degrees"), "A m^2": (1e-3, "mA m^2")}
_LIMITS = {"greater_than": ("gt", "above"), "greater_than_equal": ("ge", "at least"), "less_than": ("lt", "below"),
           "less_than_equal": ("le", "at most")}  # fmt: skip
_KINDS = {
    **dict.fromkeys(("float_type", "float_parsing"), "a number"),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float"), "a whole number"),
    **dict.fromkeys(("tuple_type", "list_type"), "a list"),
    **dict.fromkeys(("model_type", "dict_type", "model_attributes_type"), "a table of keys"),
    **{"bool_type": "true or false", "string_type": "text", "finite_number": "finite", "none_required": "null"},
    **{"string_unicode": "text of whole characters"},
}


@dataclass(frozen=True)
class Complaint:
    """What is wrong with one key: `where`, dotted, empty for the whole; `what`: continues after the key's name."""

    where: str
    what: str

    def __str__(self) -> str:
        return f"key {self.where!r} {self.what}" if self.where else self.what


def validated(model: type[Model], table: Mapping[str, Any], where: str) -> Model:
    """`model` built from a TOML table.

    Raises ConfigError naming every offending key as `where.key`; no value is coerced, clamped or replaced.
    """
    try:
        return model.model_validate(table)
    except ValidationError as error:
        found = complaints(error.errors(), model)
    raise ConfigError(
        listed(found),
        where=where,
        why=f"{len(found)} keys are wrong" if len(found) > 1 else "",
        remedy="correct the key; the shipped file of the same kind, or --help of the command, has every key with its "
        "unit",
    )


def listed(found: Sequence[object]) -> str:
    """Complaints in one line: the first of them, and how many more there are."""
    more = len(found) - _MAX_LISTED
    return "; ".join([*map(str, found[:_MAX_LISTED]), *([f"and {more} more"] if more > 0 else [])])


def complaints(errors: Sequence[Any], model: Any = None) -> list[Complaint]:
    """One complaint per key.  `errors` as pydantic lists them; `model`: the type that was to be made, if known."""
    found: dict[tuple[str, ...], tuple[list[Any], list[str]]] = {}
    for entry in errors:
        place, known = _place(entry["loc"], model, keep_last=entry["type"] in ("extra_forbidden", "missing"))
        found.setdefault(place, ([], known))[0].append(entry)
    # Of a union of a plain value and a table, what is wrong in the table says more.
    whole = {q[:length] for q in found for length in range(len(q))}
    return [Complaint(".".join(p), _words(p, *about)) for p, about in found.items() if p not in whole]


def _place(loc: Sequence[Any], model: Any, *, keep_last: bool) -> tuple[tuple[str, ...], list[str]]:
    """The keys of a location, without pydantic's names of union members, and the keys that may come last."""
    kinds = _inside(model)
    place = []
    known = []
    for number, part in enumerate(loc):
        models = [k for k in kinds if _is_model(k)]
        union = len(models) > 1 and dict not in kinds  # the keys of a table may be called as anything
        of_kind = [k for k in models if _is_tag(k, part)] if union else []
        fields = _fields(kinds)
        if isinstance(part, int):
            place.append(str(part))
        elif of_kind:
            kinds = of_kind
        elif part in fields:
            known = list(fields)
            kinds = [each for annotation in fields[part] for each in _inside(annotation)]
            place.append(part)
        elif model is None or any(k is dict for k in kinds) or (keep_last and number == len(loc) - 1):
            known = list(fields)
            place.append(str(part))
    return tuple(place), known


def _inside(annotation: Any) -> list[Any]:
    """A type and all that it is made from."""
    origin = get_origin(annotation)
    inner = [each for part in get_args(annotation) for each in _inside(part)]
    return [origin or annotation, *inner]


def _fields(kinds: list[Any]) -> dict[str, list[Any]]:
    """By name of a key: what it may be, in any of the models."""
    found: dict[str, list[Any]] = {}
    for kind in filter(_is_model, kinds):
        for name, field in kind.model_fields.items():
            found.setdefault(field.alias or name, []).append(field.annotation)
    return found


def _is_tag(model: type[BaseModel], part: Any) -> bool:
    """Whether it is the tag that distinguishes this model from the others of its union."""
    literals = [f.annotation for f in model.model_fields.values() if get_origin(f.annotation) is Literal]
    return any(get_args(each) == (part,) for each in literals)


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _words(place: tuple[str, ...], entries: list[Any], known: list[str]) -> str:
    """What is wrong with the value of one key; several entries are the members of a union, none of which fits."""
    first = entries[0]
    if first["type"] == "missing":
        return "is missing"
    if first["type"] == "extra_forbidden":
        return f"is unknown (value {_shown(first['input'])})" + _nearest(place[-1] if place else "", known)
    if first["type"] == "union_tag_not_found":
        return f"has no key {first['ctx']['discriminator']}, which says what it is"
    if first["type"] == "union_tag_invalid":
        tags = re.findall(r"'([^']*)'", first["ctx"]["expected_tags"])
        return f"has an unknown {first['ctx']['discriminator']}, {_shown(first['ctx']['tag'])}" + _nearest(
            str(first["ctx"]["tag"]), tags
        )
    for entry in entries:
        if entry["type"] == "value_error":
            return f"is wrong: {entry['ctx']['error']}"
    wanted = []
    meant = ""
    unit = _unit(place)
    for entry in entries:
        text, hint = _wanted(entry, unit)
        wanted.append(text)
        meant = meant or hint
    texts = list(dict.fromkeys(w for w in wanted if w != "null" or len(wanted) == 1))
    return f"must be {' or '.join(texts)}, got {_shown(first['input'])}{meant}"


def _wanted(entry: Any, unit: str) -> tuple[str, str]:
    """(what it must be, what was meant perhaps)."""
    kind = entry["type"]
    ctx = entry.get("ctx") or {}
    value = entry["input"]
    if kind in _LIMITS:
        name, word = _LIMITS[kind]
        return f"{word} {ctx[name]:g} {unit}".rstrip(), _other_unit(value, ctx, name, unit)
    if kind in ("literal_error", "enum"):
        allowed = re.findall(r"'([^']*)'", ctx["expected"])
        return ctx["expected"], _nearest(value, allowed) if isinstance(value, str) and _near(value, allowed) else ""
    if kind in ("too_short", "too_long"):
        word, count = ("at least", ctx["min_length"]) if kind == "too_short" else ("at most", ctx["max_length"])
        return f"a list of {word} {count}", ""
    if kind in ("string_too_short", "string_too_long"):
        word, count = ("at least", ctx["min_length"]) if kind == "string_too_short" else ("at most", ctx["max_length"])
        return f"text of {word} {count} characters", ""
    if kind == "string_pattern_mismatch":
        return f"text of the form {ctx['pattern']}", ""
    message = entry["msg"].removeprefix("Input should be ").removeprefix("a valid ")
    return _KINDS.get(kind, message), ""


def _other_unit(value: Any, ctx: Any, limit: str, unit: str) -> str:
    """A number in another unit, as people read it: 490 for a field in uT."""
    if limit not in ("lt", "le") or unit not in _MEANT or not isinstance(value, int | float):
        return ""
    factor, name = _MEANT[unit]
    if not 0 < value * factor <= ctx[limit]:
        return ""
    return f"; the unit is {unit}: did you mean {value * factor:.6g} ({value:g} {name})?"


def _unit(place: tuple[str, ...]) -> str:
    """That the name of the key ends with."""
    names = [part for part in place if not part.isdigit()]
    parts = names[-1].split("_") if names else []
    return next((u for k in range(1, len(parts)) if (u := _UNITS.get("_".join(parts[k:])))), "")


def _near(word: str, known: Sequence[str]) -> list[str]:
    return difflib.get_close_matches(word, known, n=1, cutoff=0.6)


def _nearest(word: str, known: Sequence[str]) -> str:
    found = _near(word, known)
    if found:
        return f"; did you mean {found[0]!r}?"
    return f"; there are: {', '.join(known)}" if known else ""


def _shown(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, float) and float(short := f"{value:.12g}") != value:
        return short  # without the rounding of a unit that was converted
    text = ascii(value) if isinstance(value, str) and not value.isprintable() else repr(value)
    return text if len(text) < 80 else f"{text[:76]} ..."
