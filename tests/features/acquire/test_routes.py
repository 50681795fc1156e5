import time

import pytest

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.rest import finished

SERIES = {**SHORT_JEWEL, "shots": 300, "window": None}
_WITHIN_S = 60.0


def shots(client, location):
    return client.get(f"{location}/shots", params={"limit": 1000}).json()["items"]


def until(client, location, count):
    """How many shots it had each time somebody looked, until there are so many."""
    seen, end = [], time.monotonic() + _WITHIN_S
    while not seen or seen[-1] < count:
        assert time.monotonic() < end
        time.sleep(0.02)  # whoever asks without a rest takes the time of those who measure
        seen.append(len(shots(client, location)))
    return seen


@pytest.mark.long
def test_shots_never_become_fewer_while_a_series_is_gone_on_with(client):
    series = client.post("/acquisitions", json=SERIES).headers["location"]
    until(client, series, 5)
    client.delete(series)
    finished(client, series)
    known = shots(client, series)
    before_it = client.post("/acquisitions", json=SERIES).headers["location"]
    try:
        assert client.post(f"{series}/resume", json={}).json()["state"] == "queued"
        assert [each["time_stamp"] for each in shots(client, series)] == [each["time_stamp"] for each in known]
        client.delete(before_it)
        seen = until(client, series, len(known) + 2)
    finally:
        client.delete(before_it)
        client.delete(series)
        finished(client, series)
    assert seen == sorted(seen)
    assert seen[0] >= len(known)
