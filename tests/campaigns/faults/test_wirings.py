"""A short form of the campaign over the wirings of gate and receiver; `make wiring-campaign` does all."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.campaigns.faults.wiring_trial import (
    HOLES,
    KINDS,
    LEAST_S,
    MOST_S,
    SILENT,
    SLOW,
    STILL,
    TRICKLE,
    Bench,
    Blow,
    draw,
    run,
)
from tests.campaigns.faults.wirings import WIRINGS, Wiring

SEED, QUICK_S = 3, 0.5


@pytest.fixture(scope="module", params=[pytest.param(w, id=w.name) for w in WIRINGS])
def bench(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    wiring: Wiring = request.param
    made = Bench(tmp_path_factory.mktemp("wiring"), wiring, SEED)
    yield made
    made.end()


@pytest.mark.long
@pytest.mark.parametrize("kind", [STILL, SILENT, HOLES, SLOW])
def test_power_never_meets_the_receiver_and_the_next_shot_is_good(bench: Bench, kind: str) -> None:
    found = (draw(SEED, k) for k in range(10_000))
    blow = next(b for b in found if (b.wiring, b.kind) == (bench.wiring, kind) and b.seconds < QUICK_S and not b.early)
    assert run(bench, blow).complaints == []


@pytest.mark.long
def test_samples_that_trickle_do_not_keep_the_gate_up(bench: Bench) -> None:
    if not bench.wiring.follows_host:
        pytest.skip("the card ends the gate by itself")
    wire = {"device": "io_card_0", "stream": "data", "when": "shot", "kind": "slow_link"}
    blow = Blow(0, bench.wiring, SILENT, 0.04, wire=wire | {"delay_s": 0.04, "count": TRICKLE})
    assert run(bench, blow).complaints == []


def test_a_number_is_always_the_same_blow_and_all_wirings_and_kinds_come_in_turn() -> None:
    drawn = [draw(SEED, k) for k in range(200)]
    assert drawn == [draw(SEED, k) for k in range(200)]
    assert {(b.wiring.name, b.kind) for b in drawn} == {(w.name, k) for w in WIRINGS for k in KINDS}
    assert all(LEAST_S <= b.seconds <= MOST_S for b in drawn)
