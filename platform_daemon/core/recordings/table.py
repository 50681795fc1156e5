"""A table from elsewhere: its columns of numbers, and what is known of those that are none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError


class Table(dict[str, NDArray[np.float64]]):
    """Columns by name; of a table without names by their numbers from 0.

    Attributes:
        left_out: of columns that hold no real numbers by name, why, in words.
        complex_names, counters: those of left_out that hold complex numbers, and that only count the rows.
        units: of columns whose cells, or kind, say the unit; names say those of others.
        lines: of a text, the line of each row, from 1; None: it is no text.
    """

    def __init__(self, columns: Mapping[str, NDArray[np.float64]] | Iterable[tuple[str, NDArray[np.float64]]] = ()):
        super().__init__(columns)
        self.left_out: dict[str, str] = {}
        self.complex_names: set[str] = set()
        self.counters: set[str] = set()
        self.units: dict[str, str] = {}
        self.lines: NDArray[np.int32] | None = None

    def leave_out_complex(self, name: str) -> None:
        """Note a column of complex numbers."""
        self.left_out[name] = "it holds complex numbers"
        self.complex_names.add(name)


def vector_or_matrix(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """A matrix of one row or column as (n,), any other as it is."""
    return values.reshape(-1) if values.ndim == 2 and 1 in values.shape else values


def without_scalars(table: Table, where: str) -> Table:
    """The same without them.  Raises RecordingError if nothing is left."""
    for name in [name for name, each in table.items() if each.size <= 1]:
        del table[name]
    if not table and not table.left_out:
        remedy = "save time and signal as arrays of numbers, as save('own.mat', 'time_s', 'phi_rad'); no table objects"
        raise RecordingError("holds no array of numbers", where=where, remedy=remedy)
    return table
