"""How soon a daemon answers what is asked of it first; on a machine that does nothing else (`make test-real-time`)."""

import time

import pytest

from platform_daemon.processes import web_process
from tests.kit.command_line import wait_for
from tests.kit.served import served

SHORT = {"resonator": "jewel", "sequence": {"rx_s": 0.6}}
PREPARED_S = 10.0  # what the preparation of pictures takes at most once it has begun


def seconds(ask):
    began = time.perf_counter()
    response = ask()
    assert response.status_code == 200
    return time.perf_counter() - began


@pytest.mark.real_time
def test_the_schema_is_there_as_soon_as_the_daemon_is_ready_and_a_picture_within_a_second(tmp_path):
    with served(tmp_path / "data") as daemon:
        schema_s = seconds(lambda: daemon.get("/openapi.json"))
        job = daemon.post("/acquisitions", SHORT).json()
        wait_for(lambda: daemon.get(f"/acquisitions/{job['id']}").json()["state"] == "done")
        (recording,) = (each["id"] for each in daemon.get("/recordings").json()["items"])
        time.sleep(web_process.PICTURES_AFTER_S + PREPARED_S)
        first_s, second_s = (seconds(lambda: daemon.get(f"/recordings/{recording}/frames/0/picture")) for _ in range(2))
    print(f"schema {schema_s:.2f} s, first picture {first_s:.2f} s, second {second_s:.2f} s")
    assert schema_s < 0.5
    assert first_s < 1.0
    assert second_s < 1.0
