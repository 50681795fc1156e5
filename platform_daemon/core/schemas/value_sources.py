"""Where the values come from that a series is made with, and the limits that hold for it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from typing_extensions import TypeAliasType

from .base import Absent, Schema, Vector

SourceKind = TypeAliasType("SourceKind", Literal["shipped", "file", "tuned", "ramp", "procedure", "given", "recording"])
"""shipped: a file that comes with the software; file: another file; tuned: a preset that tune has kept; ramp: what a
ramp has kept; procedure: the procedure that makes the series has chosen it; given: the request says it; recording: the
recording that is analysed holds it."""


class ValueSource(Schema):
    """One value of a series, or one limit that holds for it, and where it comes from."""

    quantity: str
    """Key of the sequence, as f_tx_hz; resonator; max_field_t: the highest field that a ramp allows, T; calibration:
    the receive calibration of an analysis."""
    value: int | float | str | Vector
    """The value, in the unit that the quantity names."""
    source: SourceKind
    """Where it comes from."""
    job: Absent[str] = None
    """Id of the job that has found it; missing: no job has."""
    date: Absent[str] = None
    """When that job has kept it, ISO 8601; missing: not known, or the job is this one."""
    path: Absent[str] = None
    """File that holds it: the path as it was named, or the name of a file in a folder of the data folder."""


@dataclass(frozen=True)
class Origin:
    """Where a value comes from; see ValueSource."""

    source: SourceKind
    job: str | None = None
    date: str | None = None
    path: str | None = None

    def of(self, quantity: str, value: Any) -> ValueSource:
        """The source of this value."""
        return ValueSource(
            quantity=quantity, value=value, source=self.source, job=self.job, date=self.date, path=self.path
        )

    def found_by(self, job: str) -> Origin:
        """The same; what this procedure finds has the id of its job."""
        return replace(self, job=job) if self.source in ("tuned", "ramp") and self.job is None else self


GIVEN = Origin("given")
PROCEDURE = Origin("procedure")
SHIPPED = Origin("shipped")
Origins = Mapping[str, Origin]
"""By key of a sequence."""


def value_sources_text(sources: Iterable[ValueSource]) -> str:
    """A line for each source, with the values that come from it."""
    lines: dict[str, list[str]] = {}
    for each in sources:
        lines.setdefault(_source_text(each), []).append(_value_text(each))
    return "\n".join(f"{', '.join(values)}: {source}" for source, values in lines.items())


def _source_text(each: ValueSource) -> str:
    path = "" if each.path is None else f" ({each.path})"
    job = "this job" if each.job is None else each.job
    date = "" if each.date is None else f" on {each.date[:10]}"
    match each.source:
        case "shipped":
            return f"shipped{path}"
        case "file":
            return f"file {each.path}"
        case "tuned":
            return f"tuned{date} by {job}{path}"
        case "ramp":
            return f"{'limit ' if each.quantity.startswith('max_') else ''}from ramp {job}{date}{path}"
        case "procedure":
            return "chosen by this procedure"
        case "given":
            return "given"
        case "recording":
            return "of the recording"


def _value_text(each: ValueSource) -> str:
    if isinstance(each.value, str):
        return f"{each.quantity} {each.value}"
    if isinstance(each.value, tuple):
        return f"{each.quantity} {','.join(f'{x:g}' for x in each.value)}"
    if each.quantity.endswith("_t"):
        return f"{each.quantity.removesuffix('_t')}_ut {1e6 * each.value:.6g}"
    return f"{each.quantity} {each.value:.6g}"
