"""What is finished of a study, as JSON lines."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tests.campaigns.angle_study.score import Score


def finished(journal: Path | None, seed: int) -> dict[int, Score]:
    """Scores of this seed by number of the record."""
    if journal is None or not journal.exists():
        return {}
    found = [_score(json.loads(line)) for line in journal.read_text(encoding="utf-8").splitlines()]
    return {score.index: score for score in found if score.seed == seed}


def _score(row: dict[str, Any]) -> Score:
    listed = {k: tuple(tuple(x) if isinstance(x, list) else x for x in v) for k, v in row.items() if type(v) is list}
    return Score(**{**row, **listed})


def keep(journal: Path | None, score: Score) -> None:
    """Add one."""
    if journal is not None:
        with journal.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(score)) + "\n")
