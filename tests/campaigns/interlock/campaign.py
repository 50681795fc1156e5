"""Runs the machine, with or without a planted mistake."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import run_state_machine_as_test
from structlog.testing import capture_logs

from tests.campaigns.interlock.bench import Bench
from tests.campaigns.interlock.machine import VISITS, InterlockMachine
from tests.campaigns.interlock.mutants import Mutant

STEPS_OF_A_RUN = 50


@dataclass(frozen=True)
class Found:
    """steps: that were made; visits: how often each ended how; why: what was broken first, "": nothing was."""

    steps: int
    visits: Counter[tuple[str, str]]
    why: str


def run(steps: int, number: int, mutant: Mutant | None = None) -> Found:
    """At least so many steps, unless something is found broken before; number: the seed.

    A run is as long as Hypothesis makes it, so that runs are added until there are enough steps.
    """
    VISITS.clear()
    while sum(VISITS.values()) < steps:
        number += 1
        with capture_logs():
            why = _some(max(10, (steps - sum(VISITS.values())) // STEPS_OF_A_RUN), number, mutant)
        if why:
            return Found(sum(VISITS.values()), Counter(VISITS), why)
    return Found(sum(VISITS.values()), Counter(VISITS), "")


def _some(runs: int, number: int, mutant: Mutant | None) -> str:
    class Machine(InterlockMachine):
        @staticmethod
        def make(wiring: str) -> Bench:
            return Bench(wiring) if mutant is None else Bench(wiring, mutant.plan)

    shrink = () if mutant is not None else (Phase.shrink,)
    how = settings(
        max_examples=runs,
        stateful_step_count=STEPS_OF_A_RUN,
        deadline=None,
        database=None,
        print_blob=False,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate, *shrink),
    )
    try:
        if mutant is None:
            run_state_machine_as_test(seed(number)(Machine), settings=how)
        else:
            with mutant.planted():
                run_state_machine_as_test(seed(number)(Machine), settings=how)
    except AssertionError as error:
        return str(error)
    return ""
