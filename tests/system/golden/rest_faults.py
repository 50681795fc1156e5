"""REST: what goes wrong at the platform, and what the operator has to do."""

from __future__ import annotations

from tests.kit.stored_jobs import job_texts
from tests.system.golden.cli_platform import FIXED
from tests.system.golden.daemon import Daemon
from tests.system.golden.rest import SHOT
from tests.system.golden.workplace import Workplace

WORLD = "backends.simulated"


def faults(place: Workplace) -> None:
    """Self-test, trip and reset, a card that delivers nothing, a wrong cable; jobs after a restart."""
    tested = ("--set", "self_test.enabled=true", "--set", "self_test.isolation_db=80.0")
    # Shot 1 and 4 are self-tests; 2 trips, 5 loses steps and 6 is not delivered.
    broken = [("amplifier_trip", 2), ("lost_steps", 5), ("card_timeout", 6)]
    wrong = [text for kind, shot in broken for text in ("--set", f"{WORLD}.faults.{kind}=[{shot}]")]
    with Daemon(place, *FIXED, *tested, *wrong) as daemon:
        daemon.job("trip", "/acquisitions", SHOT)
        daemon.settle()
        daemon.ask("trip-platform", "GET", "/platform")
        daemon.ask("trip-devices", "GET", "/devices")
        daemon.ask("trip-reset", "POST", "/devices/power_amplifier/reset", json={})
        daemon.job("lost", "/acquisitions", {**SHOT, "shots": 3})
    for identifier, text in job_texts(place.folder / "data").items():
        place.keep(f"jobs/{identifier}.json", text)
    with Daemon(place, *FIXED, *tested, "--set", f"{WORLD}.wiring.factors=[1.0, -1.0, 0.0]") as daemon:
        daemon.ask("restarted-acquisitions", "GET", "/acquisitions")
        daemon.ask("restarted-calibrations", "GET", "/calibrations")
        daemon.ask("restarted-recordings", "GET", "/recordings")
        daemon.job("wiring", "/acquisitions", SHOT)
