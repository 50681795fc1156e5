"""`platform-daemon serve` as a process."""

import pytest

from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.settings import locate
from tests.kit.command_line import assert_one_line_error, run
from tests.kit.daemon_process import daemon
from tests.kit.rest import client_at


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return tmp_path_factory.mktemp("serve") / "data"


@pytest.fixture(scope="module")
def address(data):
    """Of a daemon with a folder of resonators."""
    lab = data.with_name("lab")
    lab.mkdir()
    (lab / "t07.toml").write_text(locate("resonators", "thread").read_text())
    with daemon(data, "--resonators", lab) as found:
        yield found


@pytest.fixture(scope="module")
def client(address):
    with client_at(address) as asking:
        yield asking


def test_the_server_answers_and_neither_its_folder_nor_its_port_is_anothers(client, address, data, tmp_path):
    assert client.get("/health").json()["status"] == "ok"
    assert_one_line_error(run("serve", "--port", "0", "--data", data), 2, "another daemon")
    taken = run("serve", "--port", address.rsplit(":")[-1], "--data", tmp_path / "other")
    assert_one_line_error(taken, 2, "cannot listen")


def test_a_folder_of_resonators_is_offered_by_name(client):
    known = {f"{v}{end}" for v in ("jewel", "thread") for end in ("", "_imperfect", "_published")} | {"t07"}
    assert {each["id"] for each in client.get("/resonators").json()["items"]} == known
    asked = {"resonator": "t07", "sequence": {"rx_s": 0.6}}
    assert client.post("/acquisitions/dry-run", json=asked).json()["variant"] == "thread"


@pytest.mark.long
def test_a_folder_of_resonators_is_checked_first(tmp_path):
    (tmp_path / "broken.toml").write_text("variant = 1\n")
    refused = run("serve", "--port", "0", "--data", tmp_path / "data", "--resonators", tmp_path)
    assert_one_line_error(refused, 2, "broken.toml", "variant")
    shipped = locate("resonators", "jewel").parent
    hidden = run("serve", "--port", "0", "--data", tmp_path / "data", "--resonators", shipped)
    assert_one_line_error(hidden, 2, "ships")


@pytest.mark.long
def test_bytes_that_are_no_text_are_refused(tmp_path):
    assert_one_line_error(run("serve", "--port", "0", "--data", tmp_path / "d\udcff"), 2, "UTF-8")


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 1])
def test_a_damaged_state_is_refused_at_the_start_with_its_remedy_and_stays(tmp_path, number):
    """A daemon that started nevertheless would refuse every job, one after the other.  number: of the damaged page."""
    state = tmp_path / "state.sqlite"
    JobRecords(state).names(None)  # makes it
    content = bytearray(state.read_bytes())
    page = int.from_bytes(content[16:18], "big")
    content[number * page : (number + 1) * page] = b"\xff" * page
    state.write_bytes(content)
    refused = run("serve", "--port", "0", "--data", tmp_path)
    assert_one_line_error(refused, 1, "state.sqlite", "the state of the daemon is damaged", "put back a copy of it")
    assert state.read_bytes() == content
    for each in tmp_path.glob("state.sqlite*"):  # what the remedy says
        each.unlink()
    with daemon(tmp_path) as address, client_at(address) as asking:
        assert asking.get("/acquisitions").json()["items"] == []
