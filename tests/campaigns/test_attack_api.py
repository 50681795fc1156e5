"""A short attack on the interface; `make attack-api` is the long one."""

from __future__ import annotations

from pathlib import Path

from tests.campaigns.attack_api import attack

SLOW = "dmdt|sliding|harmonics|file|predict|fits|diagnoses|procedures"
"""Operations that read, fit or plan much for every request: their boundaries are left to the long attack."""


def test_examples_random_requests_walks_and_boundaries_bring_nothing_that_the_schema_does_not_say(
    tmp_path: Path,
) -> None:
    seed = ("--seed", "1", "--workers", "2")
    drawn = ("--phases", "examples,fuzzing,stateful", "--max-examples", "1", *seed)
    boundaries = ("--phases", "coverage", "--exclude-path-regex", SLOW, *seed)
    for done in attack(tmp_path, drawn, boundaries):
        assert done.returncode == 0, done.stdout
        assert "No issues found" in done.stdout
