"""A short attack on the interface; `make attack-api` is the long one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.campaigns.attack_api import attack

SLOW = "dmdt|sliding|harmonics|file|predict|fits|diagnoses|procedures|dry-run"
"""Operations that read, fit or plan much for every request: their boundaries are left to the long attack."""
DRAWN = ("--phases", "examples,fuzzing", "--max-examples", "1")
WALKS = ("--phases", "stateful", "--max-examples", "1")
BOUNDARIES = ("--phases", "coverage", "--exclude-path-regex", SLOW)


@pytest.mark.parametrize(
    "phases",
    [DRAWN, pytest.param(WALKS, marks=pytest.mark.long), pytest.param(BOUNDARIES, marks=pytest.mark.campaign)],
    ids=lambda p: p[1],
)
def test_examples_random_requests_walks_and_boundaries_bring_nothing_that_the_schema_does_not_say(
    tmp_path: Path, phases: Sequence[str]
) -> None:
    for done in attack(tmp_path, (*phases, "--seed", "1", "--workers", "2")):
        assert done.returncode == 0, done.stdout
        assert "No issues found" in done.stdout
