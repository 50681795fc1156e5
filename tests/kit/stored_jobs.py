"""Records of jobs, as the state of a data folder keeps them."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path


def job_texts(data: Path) -> dict[str, str]:
    """The JSON of each job by its id, in the order in which the jobs were made."""
    with closing(sqlite3.connect(data / "state.sqlite")) as sql:
        return dict(sql.execute("SELECT id, record FROM jobs ORDER BY rowid"))
