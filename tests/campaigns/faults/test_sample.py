"""A small sample of the fault campaign, of faults that do not wait long; `make fault-campaign` does all."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from tests.campaigns.faults.bench import Bench
from tests.campaigns.faults.campaign import trial
from tests.campaigns.faults.catalogue import DEAD, cells
from tests.campaigns.faults.trial import draw

SEED, SAMPLE = 7, 10


def sample() -> list[int]:
    """Numbers of faults: some of every device, without those that end in a time-out or a new start."""
    quick = [k for k, c in enumerate(cells()) if not c.site.early and c.kind not in (*DEAD, "timeout", "half_reply")]
    return sorted(int(k) for k in np.random.default_rng(SEED).choice(quick, SAMPLE, replace=False))


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    made = Bench(tmp_path_factory.mktemp("faults"), SEED)
    yield made
    made.end()


@pytest.mark.long
@pytest.mark.parametrize(
    "index",
    [pytest.param(k, marks=[pytest.mark.long] if n % 3 else []) for n, k in enumerate(sample())],
    ids=lambda k: draw(SEED, k).cell.name,
)
def test_a_fault_ends_as_it_was_said_to(bench: Bench, index: int) -> None:
    assert trial(bench, SEED, index)["complaints"] == []


@pytest.mark.long
def test_the_same_number_is_the_same_fault_and_every_cell_comes_in_turn() -> None:
    once, again = ([draw(SEED, k) for k in range(len(cells()))] for _ in range(2))
    assert once == again
    assert {fault.cell.name for fault in once} == {cell.name for cell in cells()}
    assert len({cell.name for cell in cells()}) == len(cells())
