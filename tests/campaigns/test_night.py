"""A short `make night`, and that its story is held against all who tell it."""

from dataclasses import replace

import pytest

from tests.campaigns.night.night import night
from tests.campaigns.night.story import contradictions

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return night(tmp_path_factory.mktemp("night"), 50.0, 4, last_trips=True)


def test_everybody_tells_the_same(found):
    assert contradictions(found) == []
    assert len(found.rows) >= 6
    assert any(row["state"] == "run" for row in found.rows)
    assert "failed:acquisition" in found.standing


def changed(rows, number, **others):
    return [row | others if k == number else row for k, row in enumerate(rows)]


@pytest.mark.parametrize(
    ("falsify", "said"),
    [
        (lambda n: replace(n, rows=n.rows[:2] + n.rows[3:]), "row 3 is due"),
        (lambda n: replace(n, rows=[*n.rows[:-1], n.rows[-1] | {"state": "started"}]), "has not ended"),
        (lambda n: replace(n, rows=changed(n.rows, 0, job="acquisition-x")), "is in no row"),
        (lambda n: replace(n, recordings=dict(list(n.recordings.items())[1:])), "is not there"),
        (lambda n: replace(n, events=[e for e in n.events if e["what"]["kind"] != "shot"]), "was told 0 times"),
        (lambda n: replace(n, events=[e for e in n.events if e["what"]["kind"] != "alarm"]), "never raised"),
        (lambda n: replace(n, called=[]), "called {}"),
        (lambda n: replace(n, standing=[]), "does not stand in the morning"),
        (lambda n: replace(n, blows=[]), "nothing was done to it"),
        (lambda n: replace(n, met=1), "power met"),
        (lambda n: replace(n, played=0), "0 were played"),
    ],
)
def test_another_story_is_found(found, falsify, said):
    assert any(said in each for each in contradictions(falsify(found)))
