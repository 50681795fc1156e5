"""The on-line fits of a specimen as CSV and as Parquet: the same columns with the same content."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import text_cell
from platform_daemon.core.recordings.units import unit_of
from platform_daemon.core.schemas.parameters import PARAMETERS, definition_of

Row = Mapping[str, str | float]


@dataclass(frozen=True)
class Column:
    """One column; unit None: it holds no number."""

    name: str
    kind: Literal["text", "time", "count", "number"]
    unit: str | None
    description: str


_SHOT_AND_FIT = (
    Column("recording", "text", None, "id of the recording"),
    Column("frame", "count", "1", "number of the frame in it, from 0"),
    Column("at", "time", None, "when the shot was triggered, UTC"),
    Column("shot_verdict", "text", None, "good, or refused: the shot is not to be used"),
    Column("temperature_c", "number", "degC", "temperature of the platform"),
    Column("field_t", "number", "T", "amplitude of the excitation field at the rotor"),
    Column("fit", "text", None, "name of the fit, that of its window"),
    Column("variant", "text", None, "model that was fitted"),
    Column("verdict", "text", None, "good; refused: there is no fit; blank: a shot without excitation"),
    Column("reason", "text", None, "why there is no fit"),
    Column("window_s", "number", "s", "length of the evaluation window"),
    Column("chi2_per_dof", "number", "1", "chi^2 per degree of freedom"),
    Column("nrmse", "number", "1", "root mean square of the residual over that of the signal"),
    Column("r2", "number", "1", "coefficient of determination"),
)
_NOISE = ("noise_x_v", "noise_y_v", "noise_z_v")


def columns_of(rows: Sequence[Row]) -> list[Column]:
    """Those of every table, whatever became of its shots: of shot and fit, of each parameter that has a name here, and
    the noise of x, y, z; then what adopted models and other channels add."""
    known = [*_SHOT_AND_FIT, *(each for name in PARAMETERS for each in _estimated(name)), *map(_further, _NOISE)]
    names = {column.name for column in known}
    return known + [_further(name) for name in dict.fromkeys(key for row in rows for key in row) if name not in names]


def _estimated(name: str) -> tuple[Column, Column]:
    shown = definition_of(name)
    what = f"standard deviation of {name}; nothing: it was held"
    return (
        Column(name, "number", shown.unit, shown.description),
        Column(f"{name}_std", "number", shown.unit, what),
    )


def _further(name: str) -> Column:
    plain = name.removesuffix("_std")
    what = (
        "noise of that channel beside the ring-down, RMS"
        if name.startswith("noise_")
        else definition_of(plain).description
    )
    return Column(name, "number", unit_of(plain), what if plain == name else f"standard deviation of {plain}")


def fits_csv(rows: Sequence[Row]) -> bytes:
    """A row per fit, empty where a fit has nothing."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [column.name for column in columns_of(rows)], lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: text_cell(value) if isinstance(value, str) else value for name, value in row.items()})
    return text.getvalue().encode()


def fits_parquet(rows: Sequence[Row]) -> bytes:
    """The same as Parquet: null where a fit has nothing, with unit and description in the metadata of each field.

    Raises InputError if pyarrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        remedy = "install it: pip install 'platform-daemon[parquet]'; or write a CSV"
        raise InputError("Parquet needs pyarrow", where="--parquet", remedy=remedy) from None
    kinds = {
        "text": pyarrow.string(),
        "time": pyarrow.timestamp("us", tz="UTC"),
        "count": pyarrow.int64(),
        "number": pyarrow.float64(),
    }
    columns = columns_of(rows)
    fields = [pyarrow.field(each.name, kinds[each.kind], metadata=_metadata(each)) for each in columns]
    arrays = [pyarrow.array(_values(each, rows), kinds[each.kind]) for each in columns]
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields)), sink)
    written: bytes = sink.getvalue().to_pybytes()
    return written


def _metadata(column: Column) -> dict[str, str]:
    unit = {} if column.unit is None else {"unit": column.unit}
    return {**unit, "description": column.description}


def _values(column: Column, rows: Sequence[Row]) -> list[Any]:
    found = [row.get(column.name) for row in rows]
    return found if column.kind != "time" else [None if at is None else datetime.fromisoformat(str(at)) for at in found]
