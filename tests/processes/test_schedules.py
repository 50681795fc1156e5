"""Schedules of a daemon, by REST and on the command line."""

import signal
from contextlib import suppress

import pytest

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import assert_one_line_error, here, run, wait_for
from tests.kit.served import served
from tests.kit.small_disk import small_disk

WORK = {"kind": "acquisition", "request": SHORT_JEWEL}
QUICK = {"name": "quick", "trigger": {"every_s": 2}, "work": WORK}


def rows(daemon, identifier):
    return daemon.get(f"/schedules/{identifier}/ledger").json()["items"]


def command(daemon, *words):
    return run("schedule", *words, "--data", daemon.folder)


@pytest.mark.long
def test_what_is_due_is_run_and_stands_in_the_ledger_with_its_recording(daemon):
    made = daemon.post("/schedules", QUICK)
    assert made.status_code == 201
    at = made.headers["location"]
    identifier = made.json()["id"]
    assert at == f"/schedules/{identifier}"
    wait_for(lambda: sum(row["state"] in ("run", "late") for row in rows(daemon, identifier)) >= 2, 60)
    paused = daemon.post(f"{at}/pause", {}).json()
    assert (paused["active"], paused["reason"]) == (False, "paused")
    done = [row for row in rows(daemon, identifier) if row["state"] in ("run", "late")]
    assert len({row["due"] for row in done}) == len(done)
    for row in done:
        assert daemon.get(f"/recordings/{row['recording']}").status_code == 200
    assert daemon.get(f"{at}/ledger?limit=1").json()["next"] == f"{at}/ledger?after=1&limit=1"
    assert daemon.delete(at).status_code == 200
    assert daemon.get(at).status_code == 404
    assert rows(daemon, identifier)  # it is what became of it, whoever removed it


def test_a_stop_switches_every_schedule_off_until_somebody_resumes_it(daemon):
    at = daemon.post("/schedules", {**QUICK, "trigger": {"cron": "0 0 1 1 *"}}).headers["location"]
    assert daemon.stop_all().status_code == 200
    assert daemon.get(at).json()["active"] is False
    resumed = daemon.post(f"{at}/resume", {}).json()
    assert (resumed["active"], resumed["next_due"][5:]) == (True, "01-01T00:00:00+00:00")
    daemon.delete(at)


def test_one_start_by_hand(daemon):
    at = daemon.post("/schedules", {**QUICK, "trigger": {"cron": "0 0 1 1 *"}}).headers["location"]
    wait_for(lambda: daemon.get("/platform").json()["running"] is None)
    assert daemon.post(f"{at}/run", {}).status_code == 202
    wait_for(lambda: [row["state"] for row in daemon.get(f"{at}/ledger").json()["items"]] == ["run"], 60)
    daemon.delete(at)


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"trigger": {"cron": "0 0 30 2 *"}}, "trigger"),
        ({"trigger": {"cron": "61 0 * * *"}}, "trigger"),
        ({"trigger": {"cron": "0 0 * * *", "time_zone": "Mars/Base"}}, "time_zone"),
        ({"trigger": {}}, "trigger"),
        ({"trigger": {"every_s": 5, "cron": "0 0 * * *"}}, "trigger"),
        ({"trigger": {"every_s": 0}}, "every_s"),
        ({"trigger": {"at": ["2001-01-01T00:00:00"]}}, "never due"),
        ({"until": "2001-01-01T00:00:00"}, "until"),
        ({"work": {"kind": "acquisition", "request": {"resonator": "nobody"}}}, "nobody"),
        ({"work": {"kind": "dream", "request": {}}}, "work"),
        ({"work": {"kind": "fit", "specimen": "J", "variant": "dream"}}, "no variant 'dream'"),
        ({"work": {"kind": "fit", "specimen": "J", "terms": ["dream"]}}, "dream"),
        ({"work": {"kind": "diagnosis", "specimen": "J", "base": "dream"}}, "no variant 'dream'"),
        ({"work": {"kind": "calibration", "request": {"kind": "receive", "name": "../x"}}}, "../x"),
        ({"work": {"kind": "acquisition", "request": {**SHORT_JEWEL, "shots": 1000}}}, "trigger"),
        ({"policy": "never"}, "policy"),
        ({"grace_s": -1}, "grace_s"),
    ],
)
def test_what_cannot_be_is_refused_with_the_place_and_a_remedy(daemon, change, where):
    answer = daemon.post("/schedules", {**QUICK, **change})
    assert answer.status_code == 422, answer.text
    assert where in answer.json()["detail"]
    assert answer.json()["remedy"]
    assert daemon.get("/schedules").json()["items"] == []


def test_a_preview_keeps_nothing(daemon):
    asked = {**QUICK, "trigger": {"cron": "30 2 * * *", "time_zone": "Europe/Berlin"}}
    found = daemon.post("/schedules/preview?count=400", asked).json()["due"]
    assert len(found) == 400
    spring = [due for due in found if due.startswith("2027-03-28")]
    assert spring == ["2027-03-28T03:00:00+02:00"]  # half past two is left out that night
    assert daemon.get("/schedules").json()["items"] == []


def test_a_work_that_was_saved_on_windows_is_read(daemon, tmp_path):
    """Case 09: JSON with a byte order mark."""
    work = tmp_path / "work.json"
    work.write_text('{"kind": "self_test"}\r\n', encoding="utf-8-sig")
    words = ("--work", work, "--every-s", 60, "--count", 3, "--data", daemon.folder)
    done = here("schedule", "preview", *words)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 3
    assert "due at once" in done.stderr
    work.write_text('{"kind": "self_test"}', encoding="utf-16")
    assert_one_line_error(here("schedule", "preview", *words), 2, "the file is in UTF-16: save it as UTF-8")


@pytest.mark.long
def test_the_command_line_asks_the_daemon(daemon, tmp_path):
    work = tmp_path / "work.toml"
    work.write_text('kind = "acquisition"\n[request]\nresonator = "jewel"\nshots = 1\nsequence = { rx_s = 0.6 }\n')
    made = command(daemon, "add", "mine", "--cron", "0 22 * * *", "--time-zone", "Europe/Berlin", "--work", work)
    assert made.returncode == 0, made.stderr
    identifier = made.stdout.split(":")[0]
    assert identifier in command(daemon, "list").stdout
    assert "off: paused" in command(daemon, "pause", identifier).stdout
    assert "next " in command(daemon, "resume", identifier).stdout
    assert command(daemon, "run", identifier).returncode == 0
    wait_for(lambda: " run " in command(daemon, "ledger", identifier).stdout, 60)
    often = ("preview", "--every-s", "60", "--resonator", "jewel")
    assert len(command(daemon, *often, "--count", "3").stdout.split()) == 3
    span = ("--start", "2099-01-01T00:00", "--until", "2099-01-01T00:01")
    assert command(daemon, *often, *span).stdout.split() == ["2099-01-01T00:00:00+00:00", "2099-01-01T00:01:00+00:00"]
    assert_one_line_error(command(daemon, "ledger", identifier, "--after", str(10**20)), 2, "--after")
    assert command(daemon, "remove", identifier).returncode == 0
    assert_one_line_error(command(daemon, "pause", identifier), 2, "no schedule")
    assert_one_line_error(command(daemon, "add", "x", "--every-s", "60"), 2, "--work FILE")
    work.write_text("kind = ")
    assert_one_line_error(command(daemon, "add", "x", "--every-s", "60", "--work", work), 2, "work.toml")


def test_without_a_daemon_the_command_says_how_to_start_one(tmp_path):
    assert_one_line_error(run("schedule", "list", "--data", tmp_path), 2, "no daemon", "serve --data")


@pytest.mark.parametrize("words", [("list",), ("ledger", "schedule-1")])
def test_a_file_that_is_there_is_not_overwritten_by_a_list(tmp_path, words):
    file = tmp_path / "kept.json"
    file.write_text("kept")
    assert_one_line_error(here("schedule", *words, "--data", tmp_path, "--json", file), 2, "kept.json", "--force")
    assert file.read_text() == "kept"
    nowhere = tmp_path / "no" / "kept.json"
    assert_one_line_error(here("schedule", *words, "--data", tmp_path, "--json", nowhere), 2, "folder does not exist")


@pytest.mark.long
@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
def test_a_schedule_goes_on_after_a_restart_and_no_instant_is_there_twice(tmp_path, end):
    data = tmp_path / "data"
    with served(data) as daemon:
        identifier = daemon.post("/schedules", QUICK).json()["id"]
        wait_for(lambda: any(row["state"] == "run" for row in rows(daemon, identifier)), 60)
        daemon.process.send_signal(end)
        daemon.process.wait(60)
    with served(data) as daemon:
        before = rows(daemon, identifier)
        wait_for(lambda: sum(row["state"] in ("run", "late") for row in rows(daemon, identifier)) >= 3, 60)
        found = rows(daemon, identifier)
        assert len({row["due"] for row in found}) == len(found)
        assert [row["due"] for row in found][: len(before)] == [row["due"] for row in before]
        assert daemon.get(f"/schedules/{identifier}").json()["active"] is True


@pytest.mark.long
def test_a_damaged_ledger_is_named_and_the_daemon_works_without_schedules(tmp_path):
    data = tmp_path / "data"
    with served(data) as daemon:
        daemon.post("/schedules", QUICK)
    ledger = data / "schedules.db"
    ledger.write_bytes(ledger.read_bytes()[:3000])
    with served(data) as daemon:
        told = daemon.get("/schedules")
        assert told.status_code == 507
        assert "put back a copy" in told.json()["remedy"]
        assert "cut off after 3000 bytes" in told.json()["detail"]
        wait_for(
            lambda: any(
                a["name"] == "schedules" and "cut off" in a["what"] for a in daemon.get("/alarms").json()["items"]
            )
        )
        assert daemon.post("/acquisitions", SHORT_JEWEL).status_code == 202
    assert ledger.stat().st_size == 3000


@pytest.mark.long
def test_on_a_disk_that_is_full_at_the_start_a_stop_holds_and_schedules_are_back_once_it_is_free(tmp_path):
    with small_disk(tmp_path / "disk", 40) as disk:
        data = disk / "data"
        with served(data) as daemon:
            asked = {"name": "chain", "trigger": {"every_s": 5}, "work": {"kind": "self_test"}}
            at = daemon.post("/schedules", asked).headers["location"]
        with suppress(OSError), (disk / "filler").open("wb", buffering=0) as filler:
            while True:
                filler.write(bytes(4096))
        with served(data) as daemon:
            assert daemon.get("/schedules").status_code == 507
            assert "schedules rest" in daemon.stop_all().json()["status"]
            (disk / "filler").unlink()
            wait_for(lambda: daemon.get("/schedules").status_code == 200)
            assert daemon.get(at).json()["active"] is False
        with served(data) as daemon:
            assert daemon.get(at).json()["active"] is False
            assert daemon.post(f"{at}/resume", {}).json()["active"] is True


def measured(daemon, specimen):
    at = daemon.post("/acquisitions", {**SHORT_JEWEL, "sample": specimen}).headers["location"]
    wait_for(lambda: daemon.get(at).json()["state"] == "done")
    wait_for(lambda: specimen in daemon.get("/specimens").json().get("items", []))
    return specimen


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "page"), [("fit", "fits"), pytest.param("diagnosis", "diagnoses", marks=pytest.mark.long)]
)
def test_what_is_stored_is_analysed_by_the_calendar(daemon, kind, page):
    work = {"kind": kind, "specimen": measured(daemon, f"of a {kind}")}
    at = daemon.post("/schedules", {"name": kind, "trigger": {"at": ["2099-01-01T00:00"]}, "work": work}).json()
    started = daemon.post(f"/schedules/{at['id']}/run", {})
    assert started.status_code == 202, started.text
    wait_for(lambda: rows(daemon, at["id"])[0]["state"] not in ("due", "started"))
    row = rows(daemon, at["id"])[0]
    assert (row["state"], row["job"].partition("-")[0]) == ("run", kind)
    found = daemon.get(f"/{page}/{row['job']}").json()
    assert found["state"] == "done"
    assert found["result"]


def test_the_chain_is_tested_by_the_calendar(daemon):
    asked = {"name": "chain", "trigger": {"at": ["2099-01-01T00:00"]}, "work": {"kind": "self_test"}}
    at = daemon.post("/schedules", asked).json()["id"]
    assert daemon.post(f"/schedules/{at}/run", {}).status_code == 202
    wait_for(lambda: rows(daemon, at)[0]["state"] == "run")
    found = daemon.get(f"/self-tests/{rows(daemon, at)[0]['job']}").json()
    assert found["state"] == "done"
    assert {*found["result"]["gain"]} == {"x", "y", "z"}


def test_a_specimen_that_nobody_has_measured_yet_is_a_failure_as_any_other(daemon):
    work, trigger = {"kind": "diagnosis", "specimen": "nobody's"}, {"at": ["2099-01-01T00:00"]}
    asked = {"name": "x", "trigger": trigger, "work": work, "max_failures": 2}
    made = daemon.post("/schedules", asked).json()
    for number, active in enumerate((True, False), start=1):
        daemon.post(f"/schedules/{made['id']}/run", {})
        wait_for(lambda n=number: [r["state"] for r in rows(daemon, made["id"])] == ["failed"] * n)
        assert daemon.get(f"/schedules/{made['id']}").json()["active"] is active
    assert "no recording is of" in rows(daemon, made["id"])[0]["reason"]


@pytest.mark.long
def test_the_command_line_takes_several_resonators_and_says_what_is_mounted(daemon):
    made = command(daemon, "add", "two", "--every-s", "600", "--resonator", "thread", "--resonator", "jewel")
    assert made.returncode == 0, made.stderr
    identifier = made.stdout.split(":")[0]
    found = daemon.get(f"/schedules/{identifier}").json()["request"]
    assert found["resonators"] == ["thread", "jewel"]
    assert command(daemon, "remove", identifier).returncode == 0
    assert command(daemon, "mounted", "jewel", "--by", "me").stdout == "jewel is there\n"
    told = daemon.get("/platform/resonator").json()
    assert (told["resonator"], told["by"], told["changed_by_platform"]) == ("jewel", "me", True)
    assert_one_line_error(command(daemon, "mounted", "nobody", "--by", "me"), 2, "nobody")
