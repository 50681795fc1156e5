"""A schedule of a daemon calibrates a thermometer: by the command, over REST and by the client."""

import json
import os

import pytest

from platform_daemon.client import Client
from platform_daemon.core.settings import load_specimen
from tests.kit.command_line import assert_one_line_error, here, wait_for
from tests.kit.rest import problem

SHOTS, PER_K_HZ = 8, -0.23
NEVER = {"cron": "0 0 1 1 *"}


def scheduled(daemon, name, **work):
    """A schedule that is run once, by hand, and has recorded."""
    request = {"sequence": {"rx_s": 0.6, "pause_s": 20.0}, **work}
    body = {"name": name, "trigger": NEVER, "work": {"kind": "acquisition", "request": request}}
    daemon.post("/schedules", body)
    return run_again(daemon, name)


def run_again(daemon, name):
    """Another recording of a schedule."""
    rows = lambda: daemon.get(f"{at}/ledger").json()["items"]  # noqa: E731 short
    (at,) = [
        f"/schedules/{each['id']}"
        for each in daemon.get("/schedules").json()["items"]
        if each["request"]["name"] == name
    ]
    before = {row["recording"] for row in rows()}
    wait_for(lambda: daemon.post(f"{at}/run", {}).status_code == 202)
    wait_for(lambda: {row["state"] for row in rows()} == {"run"} and len(rows()) > len(before), 120)
    (new,) = {row["recording"] for row in rows()} - before
    return new


def slope(made):
    return made["parameters"]["p1"] / made["scale"]


@pytest.fixture
def recording(daemon):
    measurand = {"name": "temperature", "unit": "degC"}
    thermometer = {**load_specimen("jewel")[0].model_dump(exclude_none=True), "measurand": measurand}
    assert daemon.post("/resonators?name=thermo", thermometer).status_code == 201
    return scheduled(daemon, "warming", resonator="thermo", shots=SHOTS)


def test_by_a_schedule_everywhere_the_same(daemon, recording, tmp_path):
    told = tmp_path / "told.json"
    of_it = ("--schedule", "warming", "--data", daemon.folder)
    done = here("measurand", "calibrate", "thermo", *of_it, "--json", told)
    assert done.returncode == 0, done.stderr
    made = json.loads(told.read_text())
    assert (made["pairs"], made["dropped"], made["version"]) == (SHOTS, 0, 1)
    assert [each["file"] for each in made["files"]] == [f"{recording}.h5"]
    assert "recordings of the schedule 'warming': 1" in made["notes"]
    assert slope(made) == pytest.approx(PER_K_HZ, abs=0.1)
    assert made["by_temperature_hz_per_k"] is None

    answer = daemon.post("/measurands", {"specimen": "thermo", "schedule": "warming", "until": "2099-01-01"})
    assert (answer.status_code, answer.headers["location"]) == (201, f"/measurands/{made['key']}@2")
    assert answer.json()["parameters"] == pytest.approx(made["parameters"])
    assert daemon.get(answer.headers["location"]).json() == answer.json()

    with Client(daemon.address) as lab:
        again = lab.resonators.calibrate("thermo", recordings=[recording])
        assert (again.version, again.parameters) == (3, pytest.approx(made["parameters"]))
        (row,) = lab.schedules["warming"].ledger()
        assert row.measurand.calibration == again.label
        warmer = _reference_of(daemon, recording, 5.0)
        by_file = lab.resonators.calibrate("thermo", schedule="warming", reference=_written(tmp_path, warmer))
        assert by_file.valid_from == pytest.approx(again.valid_from + 5.0, abs=0.01)
        assert [each.file for each in by_file.files] == ["reference", f"{recording}.h5"]

    for words, said in (
        (("--schedule", "weekly", "--data", daemon.folder), "there are: warming"),
        ((*of_it, "--since", "2099-01-01"), "has recorded nothing between 2099-01-01 and now"),
        ((*of_it, told), "by recordings or by a schedule"),
        ((told, "--since", "2026-01-01"), "choose recordings of a schedule"),
        ((*of_it, "--reference", tmp_path / "none.csv"), "the reference cannot be read"),
        (("--schedule", "warming", "--data", tmp_path), "no daemon works in this folder"),
    ):
        assert_one_line_error(here("measurand", "calibrate", daemon.folder / RESONATOR, *words), 2, said)


def test_a_damaged_recording_is_told_everywhere(daemon, recording, tmp_path):
    again = run_again(daemon, "warming")
    whole, damaged = (daemon.folder / "recordings" / f"{each}.h5" for each in (recording, again))
    damaged.write_bytes(damaged.read_bytes()[:30_000])
    os.utime(damaged, (0, 0))  # what has just changed may still be written
    of_it = ("--schedule", "warming", "--data", daemon.folder)
    done = here("measurand", "calibrate", "thermo", *of_it, "--json", tmp_path / "told.json")
    assert done.returncode == 0, done.stderr
    assert f"note: not readable, and left out: {damaged.name}: " in done.stdout
    assert f"kept: {daemon.folder / 'measurands'}" in done.stdout
    answer = daemon.post("/measurands", {"specimen": "thermo", "schedule": "warming"})
    assert answer.status_code == 201
    with Client(daemon.address) as lab:
        made = lab.resonators.calibrate("thermo", schedule="warming")
    assert made.pairs == SHOTS
    for notes in (json.loads((tmp_path / "told.json").read_text())["notes"], answer.json()["notes"], made.notes):
        assert any(note.startswith(f"not readable, and left out: {damaged.name}: ") for note in notes)
    named = problem(daemon.post("/measurands", {"specimen": "thermo", "recordings": [recording, again]}), 422)
    assert damaged.name in named["detail"]

    whole.write_bytes(b"nothing")
    os.utime(whole, (0, 0))
    assert_one_line_error(here("measurand", "calibrate", "thermo", *of_it), 2, NONE_READ)
    told = problem(daemon.post("/measurands", {"specimen": "thermo", "schedule": "warming"}), 422)
    assert NONE_READ in told["detail"]


NONE_READ = "warming: no recording of the schedule can be read"
RESONATOR = "resonators/thermo@1.toml"


def test_what_is_refused_over_rest(daemon, recording):
    def refused(status, **body):
        return problem(daemon.post("/measurands", {"specimen": "thermo", **body}), status)["detail"]

    assert "there are: warming" in refused(404, schedule="weekly")
    assert "declared as no sensor" in refused(422, specimen="jewel", schedule="warming")
    assert "give `schedule`, or `recordings`" in refused(422)
    assert "choose recordings of a `schedule`" in refused(422, recordings=[recording], since="2026-01-01")
    assert "no recording 'nothing'" in refused(404, recordings=["nothing"])
    assert "the heading is not that of a reference" in refused(422, schedule="warming", reference="a,b\n1,2\n3,4\n")


def _reference_of(daemon, recording, offset_k):
    """What another thermometer read with each shot."""
    shots = daemon.get(f"/acquisitions/{recording}/shots").json()["items"]
    rows = [f"{each['time_stamp']},{each['temperature_c'] + offset_k},0.02" for each in shots]
    return "\n".join(["time,temperature [degC],u [degC]", *rows])


def _written(folder, text):
    path = folder / "reference.csv"
    path.write_text(text)
    return path
