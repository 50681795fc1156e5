"""A few records of the study of angle records, and what makes them; `make angle-study` does all."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.campaigns import angle_study
from tests.campaigns.angle_study.bad_inputs import BAD, write_bad
from tests.campaigns.angle_study.cases import CASES, SIGMAS, drawn
from tests.campaigns.angle_study.command import Command
from tests.campaigns.angle_study.journal import finished, keep
from tests.campaigns.angle_study.motion import reading, vector
from tests.campaigns.angle_study.page import document
from tests.campaigns.angle_study.record import record_of
from tests.campaigns.angle_study.score import scored
from tests.campaigns.angle_study.truth import true_reading

SEED = 1
QUICK = (17, 28, 30)  # nothing missing, a kick, a second mode
MOTIONS = (
    {"coulomb": 0.05, "excess": 0.5, "speed": 1.0, "quadratic": 0.003},
    {"cubic": 0.02, "bias": 0.1, "drift": 1e-4, "kick": 0.3, "kick_s": 20.0},
    {"coulomb": 0.4},
    {"angle_damping": 0.01, "mode_cos": 0.01, "mode_hz": 3.0, "mode_tau": 5.0, "zero": 0.01, "zero_tau": 9.0},
)


@pytest.fixture(scope="module")
def command() -> Iterator[Command]:
    made = Command(60.0)
    yield made
    made.close()


def test_what_makes_the_records_knows_nothing_of_this_project() -> None:
    for name in ("motion", "truth", "peer", "cases", "record", "bad_inputs"):
        path = Path(angle_study.__file__).with_name(f"{name}.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) and node.level == 0 else []
            assert not {n.split(".")[0] for n in names} & {"platform_daemon", "sim_backend", "drivers", "sequences"}


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda m: next(iter(m)))
def test_both_integrators_agree(motion: dict[str, float]) -> None:
    motion = {"f_hz": 1.2, "lambda": 0.01, "phi": 0.9, "v": -0.8, "offset": 0.02} | motion
    times = np.arange(0.0, 40.0, 0.01)
    true, rests_s = true_reading(times, motion)
    assert abs(reading(times, vector(motion)) - true).max() < 1e-8
    assert (rests_s < 40.0) == (motion.get("coulomb") == 0.4)


def test_a_number_is_the_same_record_and_every_case_has_every_visibility() -> None:
    assert drawn(SEED, 5) == drawn(SEED, 5) != drawn(SEED + 1, 5)
    draws = [drawn(SEED, k) for k in range(len(CASES) * len(SIGMAS))]
    assert len({(d.case.name, d.sigma) for d in draws}) == len(draws)


@pytest.mark.long
def test_a_few_records_are_scored_and_kept(command: Command, tmp_path: Path) -> None:
    journal = tmp_path / "journal.jsonl"
    scores = [scored(record_of(SEED, k), command, tmp_path) for k in QUICK]
    for score in scores:
        keep(journal, score)
    assert list(finished(journal, SEED).values()) == scores
    assert [s.case for s in scores] == ["viscous", "kick", "second-mode"]
    assert not any(s.result in ("traceback", "slow") or s.clipping for s in scores)
    assert scores[0].result == "exact"
    assert scores[2].right
    assert "3 of 3 synthetic" in document(scores, 3, SEED)


@pytest.mark.long
@pytest.mark.parametrize("name", BAD)
def test_a_bad_input_never_ends_in_a_traceback(command: Command, tmp_path: Path, name: str) -> None:
    path = write_bad(name, tmp_path)
    assert all(command(what, path).code in (0, 2, 3) for what in ("diagnose", "fit"))


@pytest.mark.campaign
def test_a_record_of_every_case_is_diagnosed_without_a_traceback(command: Command, tmp_path: Path) -> None:
    scores = [scored(record_of(SEED, k), command, tmp_path) for k in range(len(CASES))]
    assert [s.case for s in scores if s.result == "traceback"] == []
