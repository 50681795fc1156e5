"""A series whose daemon was killed has failed, with when and how, and an alarm stands at the next start."""

import os
import signal
from datetime import UTC, datetime, timedelta

import pytest

from tests.kit.command_line import wait_for
from tests.kit.served import served

SERIES = {"resonator": "jewel", "shots": 5000, "window": None, "sequence": {"rx_s": 0.6}}


@pytest.mark.long
@pytest.mark.parametrize(
    ("killed", "how"), [(("main",), "main process was killed"), (("hardware", "main"), "its process was killed")]
)
def test_kill_9_of_a_daemon_that_measures(tmp_path, killed, how):
    data = tmp_path / "data"
    with served(data) as daemon:
        series = f"/acquisitions/{daemon.post('/acquisitions', SERIES).json()['id']}"
        wait_for(lambda: daemon.get(series).json()["progress"]["done"] >= 2)
        for name in killed:
            os.kill(daemon.process.pid if name == "main" else daemon.pid(name), signal.SIGKILL)
        at = datetime.now(UTC)
    with served(data) as again:
        found = again.get(series).json()
        assert found["state"] == "failed"
        assert found["error"]["detail"].startswith("the daemon ended while this acquisition was running")
        assert how in found["error"]["detail"]
        times = [word.rstrip(";.") for word in found["error"]["detail"].split() if word.startswith("20")]
        assert abs(datetime.fromisoformat(times[0]) - at) < timedelta(seconds=60)
        wait_for(lambda: any(a["name"] == "failed:acquisition" for a in again.get("/alarms").json()["items"]))
        (alarm,) = (a for a in again.get("/alarms").json()["items"] if a["name"] == "failed:acquisition")
        assert alarm["cleared"] is None
        assert how in alarm["what"]
        assert again.get(f"/recordings/{series.rpartition('/')[2]}").json()["frames"] >= 2
