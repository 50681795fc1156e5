"""Requests from keyword arguments: a table and parts of it go together, in any order."""

import pytest

from drivers.errors import InputError
from platform_daemon.client.requests import request_from
from platform_daemon.core.schemas.requests import AcquisitionRequest, SequencePatch


def made(**values):
    return request_from(AcquisitionRequest, {"resonator": "jewel", **values}, "measure").sequence


@pytest.mark.parametrize(
    "values",
    [
        {"pause_s": 2.0, "sequence": {"rx_s": 0.6}},
        {"sequence": {"rx_s": 0.6}, "pause_s": 2.0},
        {"sequence": SequencePatch(rx_s=0.6), "pause_s": 2.0},
        {"rx_s": 0.6, "pause_s": 2.0},
    ],
)
def test_a_table_and_a_part_of_it(values):
    assert made(**values).model_dump(exclude_unset=True) == {"rx_s": 0.6, "pause_s": 2.0}


def test_a_table_is_not_changed_by_a_part_beside_it():
    table = {"rx_s": 0.6}
    made(sequence=table, pause_s=2.0)
    assert table == {"rx_s": 0.6}


@pytest.mark.parametrize("part", [{"rx_s": 0.8}, {"rx_ms": 800.0}, {"sequence.rx_s": 0.8}])
def test_a_part_that_the_table_has_already(part):
    with pytest.raises(InputError, match="are the same"):
        made(sequence={"rx_s": 0.6}, **part)
