"""Options of a command that are derived from the model of its request.

A field of a request is declared once, in a model of requests: its type, unit, limits, default and description
give the REST schema, the option, its help and the error of a value outside its limits.  A command lists the fields that
it offers by their dotted keys:

    @option_groups
    def ramp(request: Annotated[Keys, offers("RampRequest", "acquisition.resonator", "step_ut")], ...) -> None:

offers `--resonator` and `--step-ut`.  `request` holds the keys that were given, in SI units, as the model reads them:
`{"acquisition": {"resonator": "jewel"}, "step_t": 1e-05}`.  A key that ends in `_ut` stands for the field in T.

The models themselves are not imported for the help of a command, because pydantic takes longer than all the rest: the
table `request_fields` is written from them by `python -m tests.kit.request_fields`, and a test compares the two.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import wraps
from typing import Annotated, Any, Optional, get_args, get_origin, get_type_hints

import typer

from drivers.errors import InputError

from .parsing import parse_axis, parse_window
from .request_fields import REQUEST_FIELDS, Limits, RequestField

Keys = dict[str, Any]
"""Keys of a request as they were given, nested as the model is."""
_MICRO = "_ut"
_TESLA_PER_UT = 1e-6
_LEAST_UT = 0.01
"""Fields below, 10 nT, move no rotor; the Earth's field varies by ten times that in a day.  They were meant in T."""
_READERS: dict[str, Callable[[str], Any]] = {"axis": parse_axis, "window": parse_window}
"""Of fields that are written as text and mean a number, or a list of numbers."""


@dataclass(frozen=True, kw_only=True)
class Offered:
    """One field of a request, as a command offers it."""

    key: str
    """Where its value goes, dotted, in SI units: `acquisition.sequence.field_t`."""
    name: str
    """Name of the parameter, by which click hands over its value: `field_ut`."""
    flag: str
    """As on the command line: `--field-ut`, or `--keep/--no-keep`."""
    field: RequestField
    """Type, default, limits and help."""
    factor: float | None = None
    """SI value of one unit of the option; None: it has the unit of the field, or none."""
    read: Callable[[str], Any] | None = None
    """Makes a value of the text that was given; None: the text is the value."""

    @property
    def parameter(self) -> inspect.Parameter:
        """The option, as typer reads it; click itself refuses whole numbers outside their limits."""
        field = self.field
        counted = field.limits if field.kind is int and field.limits is not None else Limits()
        declared = typer.Option(self.flag, help=self._help, min=counted.low, max=counted.high)
        kind: Any = list[field.kind] if field.many else field.kind  # type: ignore[name-defined]
        default = inspect.Parameter.empty if field.required else self._default
        if default is None:
            kind = Optional[kind]  # noqa: UP045  (a type that is made here, not written)
        return inspect.Parameter(
            self.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, declared]
        )

    def value(self, given: Any) -> Any:
        """What the model gets for what was given on the command line.  Raises InputError for a text that is none, or a
        field in T."""
        if self.read is not None:
            return self.read(given)
        if self.field.many:
            return tuple(given)
        if self.factor is None or given is None:
            return given
        if self.name.endswith(_MICRO) and 0.0 < given < _LEAST_UT:
            remedy = f"the unit is uT: did you mean {given / _TESLA_PER_UT:.6g} ({given:g} T)?"
            raise InputError(f"is {given:g} uT, too small a field", where=self.flag, remedy=remedy)
        return given * self.factor

    @property
    def _default(self) -> Any:
        found = self.field.default
        if self.field.kind is bool:
            return bool(found)
        if self.field.many or found is None:
            return None
        return found if self.factor is None else float(f"{found / self.factor:.12g}")

    @property
    def _help(self) -> str:
        text, limits = self.field.help, self.field.limits
        shown = limits is not None and self.field.kind is float
        return f"{text} [{limits.text(self.factor or 1.0)}]" if shown and limits is not None else text


def offers(model: str, *keys: str, changes: Mapping[str, Mapping[str, Any]] | None = None) -> tuple[Offered, ...]:
    """The fields of a model that a command offers, in the order of its help.

    keys: dotted; `acquisition.` stands for the model of an acquisition.  changes: by key, what the command says
    otherwise than the model: fields of `RequestField`, and `flag`.
    """
    return tuple(_offered(model, key, dict((changes or {}).get(key, {}))) for key in keys)


def _offered(model: str, key: str, changes: dict[str, Any]) -> Offered:
    micro = key.endswith(_MICRO)
    full = key.removesuffix(_MICRO) + "_t" if micro else key
    above, _, inner = full.partition("acquisition.")
    field = REQUEST_FIELDS["AcquisitionRequest" if inner else model][inner or above]
    name = key.rpartition(".")[2]
    flag = f"--{name.replace('_', '-')}"
    if field.kind is bool and field.default:
        flag += f"/--no-{name.replace('_', '-')}"
    flag = changes.pop("flag", flag)
    if micro:
        changes.setdefault("help", field.help.replace(", T", ", uT"))
    factor = _TESLA_PER_UT if micro else None
    return Offered(
        key=full, name=name, flag=flag, field=replace(field, **changes), factor=factor, read=_READERS.get(name)
    )


def option_groups(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose parameters may be groups of options.

    A parameter is a group if its type is a dataclass, of which every field is an option as typer declares it, or if it
    is `Annotated[Keys, offers(...)]`.  Every other parameter is handed on as it is.
    """
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, Any] = {}
    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(command).parameters.values():
        hint = hints[parameter.name]
        if get_origin(hint) is Annotated and get_args(hint)[0] is Keys:
            groups[parameter.name] = get_args(hint)[1]
            parameters += [each.parameter for each in groups[parameter.name]]
        elif is_dataclass(hint):
            groups[parameter.name] = hint
            parameters += _parameters_of(hint)
        else:
            parameters.append(
                inspect.Parameter(
                    parameter.name, inspect.Parameter.KEYWORD_ONLY, default=parameter.default, annotation=hint
                )
            )

    @wraps(command)
    def run(**given: Any) -> None:
        command(**{name: _collected(group, given) for name, group in groups.items()}, **given)

    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {each.name: each.annotation for each in parameters}
    return run


def _parameters_of(group: Any) -> list[inspect.Parameter]:
    hints = get_type_hints(group, include_extras=True)
    return [
        inspect.Parameter(
            each.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if each.default is MISSING else each.default,
            annotation=hints[each.name],
        )
        for each in fields(group)
    ]


def _collected(group: Any, given: dict[str, Any]) -> Any:
    """The value of a group; its options are taken out of `given`."""
    if is_dataclass(group):
        return group(**{each.name: given.pop(each.name) for each in fields(group)})  # type: ignore[operator]
    keys: Keys = {}
    for each in group:
        value = given.pop(each.name)
        if value is None or (value is False and each.field.default is None):
            continue
        *above, last = each.key.split(".")
        place = keys
        for part in above:
            place = place.setdefault(part, {})
        place[last] = each.value(value)
    return keys
