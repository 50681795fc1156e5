"""A short attack on the interface; `make attack-api` is the long one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.campaigns.attack_api import attack

SLOW = "dmdt|sliding|harmonics|file|predict|fits|diagnoses|procedures|dry-run"
"""Operations that read, fit or plan much for every request: they are left to the longer attacks."""
DRAWN = ("--phases", "examples,fuzzing", "--max-examples", "1")
WALKS = ("--phases", "stateful", "--max-examples", "1")
QUICK = ("--exclude-path-regex", SLOW)
BOUNDARIES = ("--phases", "coverage", *QUICK)


@pytest.mark.parametrize(
    "runs",
    [
        pytest.param([(*DRAWN, *QUICK)], id="drawn", marks=pytest.mark.campaign),
        pytest.param([DRAWN, WALKS], id="drawn-of-all-and-walks", marks=pytest.mark.long),
        pytest.param([BOUNDARIES], id="boundaries", marks=pytest.mark.campaign),
    ],
)
def test_examples_random_requests_walks_and_boundaries_bring_nothing_that_the_schema_does_not_say(
    tmp_path: Path, runs: Sequence[Sequence[str]]
) -> None:
    for done in attack(tmp_path, *((*run, "--seed", "1", "--workers", "2") for run in runs)):
        assert done.returncode == 0, done.stdout
        assert "No issues found" in done.stdout
