"""What Octave writes by `save -text`."""

from __future__ import annotations

import re

import numpy as np

from drivers.errors import RecordingError

from .table import Table, vector_or_matrix, without_scalars

OCTAVE = "# Created by Octave"


def octave_table(text: str, where: str) -> Table:
    """The variables of a file that Octave wrote by `save -text`: matrices and scalars, others are left out.

    A matrix of several rows and columns is (rows, columns).  Raises RecordingError.
    """
    found = Table()
    for block in re.split(r"^# name: ", text, flags=re.MULTILINE)[1:]:
        name, *lines = block.splitlines()
        heads = dict(re.findall(r"^# (\w+): (.*)$", block, flags=re.MULTILINE))
        kind = heads.get("type", "")
        if kind not in ("matrix", "scalar"):
            if kind.startswith("complex"):
                found.leave_out_complex(name.strip())
            continue
        numbers = " ".join(line for line in lines if not line.startswith("#"))
        try:
            values = np.array(numbers.replace("NA", "nan").split(), dtype=np.float64)
            shape = (1, 1) if kind == "scalar" else (int(heads["rows"]), int(heads["columns"]))
            found[name.strip()] = vector_or_matrix(values.reshape(shape))
        except (KeyError, ValueError) as error:
            remedy = "save it again, as 2-D arrays of real numbers"
            raise RecordingError(f"{name!r} cannot be read", where=where, why=str(error), remedy=remedy) from None
    return without_scalars(found, where)
