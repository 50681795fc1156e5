"""A service that runs by the unit of the documents, and people who look at its devices from elsewhere.

The unit takes /tmp, the homes and most of the file system from the service; a look must find its owner all the same.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import psutil
import pytest
from numba.core.caching import _CacheLocator  # noqa: PLC2701 there is no public way to the names of its folders

from platform_daemon.core.guard.guard_client import guard_for
from platform_daemon.core.guard.ownership import take_ownership
from platform_daemon.core.guard.state_dir import state_dir_of
from tests.kit.command_line import COMMAND, wait_for
from tests.kit.emulated_lab import Lab
from tests.kit.rest import client_at
from tests.kit.unit_isolation import ROOT, isolated, needs_namespaces, unit_section

pytestmark = needs_namespaces
SERIES = {"resonator": "jewel", "shots": 2, "sequence": {"rx_s": 0.5, "pause_s": 300}, "window": None}
"""It rests between its shots, so that a busy computer, on which shots come late, does not end it."""


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    made = Lab(tmp_path_factory.mktemp("lab"))
    yield made
    made.emulator.close()


def on(lab):
    return "--platform", "emulated", "--endpoints", lab.endpoints


def devices_of(lab):
    """Folders of what stands for the lab's cables, which a service sees as it sees /dev."""
    serial = json.loads(lab.endpoints.read_text())["serial"].values()
    return sorted({Path(each).parent for each in serial} | {lab.endpoints.parent})


def person(tmp_path, *arguments):
    """A command in another login: no folder of its state is that of the service."""
    environment = os.environ | {"XDG_STATE_HOME": str(tmp_path / "person")}
    return subprocess.run(
        [COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=120, env=environment, check=False
    )


def test_the_unit_isolates_and_names_no_place_of_locks():
    service = unit_section()
    assert (service["PrivateTmp"], service["ProtectHome"], service["ProtectSystem"]) == ("yes", "yes", "strict")
    assert "AF_UNIX" in service["RestrictAddressFamilies"].split()  # the claim of the devices is such a socket
    assert "PrivateNetwork" not in service


def series_that_rests(http):
    """Address of a series that has made its first shot."""
    for _ in range(5):  # the self-test before it may come late, too
        made = http.post("/acquisitions", json=SERIES)
        assert made.status_code == 202, made.text
        at = f"/acquisitions/{made.json()['id']}"
        wait_for(lambda at=at: http.get(at).json()["progress"]["phase"] in ("shot 2: wait", "failed"), 120)
        if http.get(at).json()["state"] == "running":
            return at
    raise AssertionError(http.get(at).json()["error"])


def connections_to_the_card(lab, daemon):
    """Both ends of each connection of the daemon to the emulated cards."""
    cards = json.loads(lab.endpoints.read_text())["io_cards"]
    ports = {each[name] for each in cards for name in ("command_port", "data_port")}
    return {
        (each.laddr.port, each.raddr.port)
        for process in psutil.Process(daemon).children(recursive=True)
        for each in process.net_connections("tcp")
        if each.status == psutil.CONN_ESTABLISHED and each.raddr.port in ports
    }


@pytest.mark.long
def test_nobody_who_looks_ends_the_series_of_a_service_and_who_stops_stops_it(lab, tmp_path):
    """Case 01: a look from a login that does not share the /tmp of the service."""
    data = tmp_path / "service/data"
    data.parent.mkdir()
    log = tmp_path / "serve.log"
    serve = [COMMAND, "serve", "--port", "0", "--data", data, *on(lab)]
    command = isolated(serve, [data.parent, *devices_of(lab)])
    environment = os.environ | {"XDG_STATE_HOME": str(data.parent / "state"), "TMPDIR": "/tmp"}
    with log.open("wb") as errors:
        daemon = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=environment)
    try:
        first = daemon.stdout.readline()
        assert first, log.read_text()
        with client_at(first.split()[-1]) as http:
            wait_for(lambda: http.get("/ready").json()["ready"])
            at = series_that_rests(http)
            before = connections_to_the_card(lab, daemon.pid)
            assert len(before) == 4  # a command and a data port for each board

            found = tmp_path / "devices.json"
            looked = person(tmp_path, "devices", *on(lab), "--json", found)
            assert looked.returncode == 0, looked.stderr
            assert f"the daemon on {data} owns the devices" in looked.stdout
            assert {each["device"] for each in json.loads(found.read_text())["devices"]} >= {"io_card", "lna"}
            looked = person(tmp_path, "doctor", *on(lab), "--json", tmp_path / "doctor.json", "--data", data)
            findings = json.loads((tmp_path / "doctor.json").read_text())["findings"]
            rows = {each["check"]: each["found"] for each in findings}
            assert rows["device: io_card"] == "answers the daemon"
            assert "owned by process" in rows["supervisor"]
            refused = person(tmp_path, "measure", "--resonator", "jewel", "--out", tmp_path / "x.h5", *on(lab))
            assert refused.returncode == 2
            assert "have an owner" in refused.stderr
            assert connections_to_the_card(lab, daemon.pid) == before  # whoever connects throws the client out
            job = http.get(at).json()
            assert job["state"] == "running", job

            stopped = person(tmp_path, "outputs-off", *on(lab))
            assert stopped.returncode == 0, stopped.stderr
            assert f"the daemon on {data} has stopped everything" in stopped.stdout
            wait_for(lambda: http.get(at).json()["state"] == "cancelled")
    finally:
        daemon.terminate()
        daemon.stdout.read()
        daemon.wait(60)
    assert lab.violations() == ()


@pytest.mark.parametrize("command", ["devices", "outputs-off", "doctor"])
def test_a_command_inside_of_the_service_finds_the_owner_outside_of_it(lab, tmp_path, command):
    guard = guard_for(lab.file().section)
    inside = isolated([COMMAND, command, *on(lab)], [tmp_path, *devices_of(lab)])
    environment = os.environ | {"XDG_STATE_HOME": str(tmp_path / "service"), "COLUMNS": "400"}  # no line is broken
    try:
        done = subprocess.run(inside, capture_output=True, text=True, timeout=120, env=environment, check=False)
    finally:
        guard.close()
    assert f"process {os.getpid()}" in done.stdout + done.stderr
    if command != "doctor":
        assert done.returncode == 1
        assert f"kill {os.getpid()}" in done.stderr


@pytest.mark.parametrize("command", ["devices", "outputs-off"])
def test_the_daemon_of_another_account_is_named_with_what_to_do(lab, tmp_path, command):
    if os.geteuid() != 0:
        pytest.skip("only root can run a command as another account")
    data = tmp_path / "data"
    data.mkdir(mode=0o700)
    lab.endpoints.parent.chmod(0o755)
    ownership = take_ownership(state_dir_of(lab.file().section), "emulated", data)
    state = tmp_path / "state"
    state.mkdir()
    os.chown(state, 12345, 12345)
    environment = os.environ | {"XDG_STATE_HOME": str(state)}
    try:
        command = isolated([COMMAND, command, *on(lab)], [state, data, *devices_of(lab)], 12345)
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment, check=False)
    finally:
        ownership.release()
    assert done.returncode == 1, done
    assert "the daemon cannot be reached from this account" in done.stderr
    assert "Permission denied" in done.stderr
    assert "run this command as the account root" in done.stderr
    assert "Traceback" not in done.stderr


def test_what_root_has_left_behind_locks_no_account_out(lab, tmp_path):
    """Case 05. Root looks at the devices in the state of a service; the service can use it afterwards."""
    if os.geteuid() != 0:
        pytest.skip("only root can leave something behind that another account cannot use")
    account = 12345
    home = tmp_path / "state"
    home.mkdir()
    os.chown(home, account, account)
    environment = os.environ | {"XDG_STATE_HOME": str(home)}
    done = subprocess.run(
        [COMMAND, "outputs-off", *map(str, on(lab))], capture_output=True, text=True, env=environment, timeout=120,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    made = [home / "platform-daemon", *(home / "platform-daemon").rglob("*")]
    assert (home / "platform-daemon" / state_dir_of(lab.file().section).name / "owner") in made
    assert {each.stat().st_uid for each in made} == {account}


def compiled_but_few(place):
    """A folder of kernels as numba keeps them for an account, with all that are compiled beside their sources but those
    that take no long time: to compile them all takes half a minute of a processor.  The names of their files."""
    kept = set()
    for package in ("platform_daemon", "sim_backend"):
        for path in (ROOT / package).rglob("*.nb[ci]"):
            if "screening" not in path.parts:
                folder = place / _CacheLocator.get_suitable_cache_subpath(str(path.parents[1] / "any.py"))
                folder.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, folder)
                kept.add(path.name)
    return kept


@pytest.mark.long
def test_an_account_without_home_that_cannot_write_the_package_measures_by_rest(tmp_path):
    """Case 07: the first shot of a service whose account can write nothing but its data and its state."""
    if os.geteuid() != 0:
        pytest.skip("only root can run a daemon as another account")
    work = tmp_path / "srv"
    kernels = work / "state/platform-daemon/kernels"
    seed = compiled_but_few(kernels)
    for each in (work, *work.rglob("*")):
        os.chown(each, 12345, 12345)
    variables = ("env", "-i", "PATH=/usr/bin:/bin", f"XDG_STATE_HOME={work}/state")
    serve = [*variables, COMMAND, "serve", "--port", "0", "--data", work / "data"]
    log = tmp_path / "serve.log"
    with log.open("wb") as errors:
        daemon = subprocess.Popen(
            isolated(serve, [work], 12345), stdout=subprocess.PIPE, stderr=errors, text=True, cwd=work
        )
    try:
        first = daemon.stdout.readline()
        assert first, log.read_text()
        with client_at(first.split()[-1]) as http:
            wait_for(lambda: http.get("/ready").json()["ready"], 600)  # it compiles, and keeps that with its state
            made = http.post("/acquisitions", json={"resonator": "jewel", "shots": 1, "sequence": {"rx_s": 0.6}})
            at = made.headers["location"]
            wait_for(lambda: http.get(at).json()["state"] not in ("queued", "running"), 300)
            job = http.get(at).json()
            assert (job["state"], job["result"]["shots"]) == ("done", 1), job
            assert http.get(f"/recordings/{job['id']}/frames/0/picture").content.startswith(b"\x89PNG")
    finally:
        daemon.terminate()
        daemon.stdout.read()
        daemon.wait(60)
    assert "Traceback" not in log.read_text()
    assert "Matplotlib created a temporary cache" not in log.read_text()
    made_here = {path.name for path in work.iterdir()}
    assert made_here == {"data", "state"}  # no folder `~`
    assert {path.name for path in kernels.rglob("*.nbc")} - seed  # what was missing is compiled, and kept
    assert {path.stat().st_uid for path in work.rglob("*")} == {12345}
