"""What crosses the socket is what is on the other side of it, errors too."""

import errno
import os
import shutil
import socket
import stat
import threading
import time
from types import SimpleNamespace

import pytest

from drivers.errors import DeviceStateError, InputError, SequenceRejected
from platform_daemon.engine import UnknownId
from platform_daemon.link.address import NAME, connected
from platform_daemon.link.client import RemoteHardware
from platform_daemon.link.errors import HardwareAway
from platform_daemon.link.hardware import Hardware
from platform_daemon.link.line import ALIVE, Line
from platform_daemon.link.recent import Recent
from platform_daemon.link.server import LinkServer
from platform_daemon.link.wire import methods
from platform_daemon.schemas import (
    AcquisitionRequest,
    ActivationRequest,
    CalibrationRequest,
    LinkCall,
    SweepRequest,
)
from platform_daemon.store.errors import StorageUnusable
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for

REQUEST = AcquisitionRequest.model_validate(SHORT_JEWEL)


def ended(linked, job):
    wait_for(lambda: linked.remote.job(job.kind, job.identifier).state.final)
    return linked.remote.job(job.kind, job.identifier)


def test_a_series_is_the_same_on_both_sides(linked):
    job = linked.remote.acquire(REQUEST)
    assert job.request == REQUEST
    done = ended(linked, job)
    assert done == linked.owned.job("acquisition", job.identifier)
    assert done.result.recording == job.identifier
    assert job.identifier in linked.remote.job_ids("acquisition")
    assert linked.remote.jobs("acquisition", (job.identifier,)) == (done,)
    assert linked.remote.last_harmonics() == linked.engine.live.latest


def test_state_and_plans_are_the_same_on_both_sides(linked):
    assert linked.remote.status().platform == linked.engine.status().platform
    assert len(linked.remote.devices().devices) == len(linked.engine.devices().devices)
    assert linked.remote.warm().keys() == linked.engine.warm.keys()
    assert linked.remote.dry_run(REQUEST) == linked.owned.dry_run(REQUEST)
    sweep = SweepRequest.model_validate(
        {"kind": "sweep", "acquisition": SHORT_JEWEL, "over": [{"key": "field_ut", "values": [100.0, 200.0]}]}
    )
    assert linked.remote.dry_run_procedure(sweep) == linked.owned.dry_run_procedure(sweep)


def test_a_calibration_that_the_disk_could_not_keep_moves_nothing(linked, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=1000))
    before = linked.owned.job_ids("calibration")
    with pytest.raises(StorageUnusable, match=r"calibrations.*Remedy: free the disk"):
        linked.remote.calibrate(CalibrationRequest(kind="receive"))
    assert linked.owned.job_ids("calibration") == before


@pytest.mark.parametrize(
    ("ask", "error"),
    [
        (lambda r: r.job("acquisition", "nothing"), UnknownId),
        (lambda r: r.cancel("acquisition", "nothing"), UnknownId),
        (lambda r: r.acquire(REQUEST.model_copy(update={"resonator": "/etc/passwd"})), InputError),
        (
            lambda r: r.acquire(AcquisitionRequest.model_validate({**SHORT_JEWEL, "sequence": {"field_t": 5e-3}})),
            SequenceRejected,
        ),
        (lambda r: r.activate(ActivationRequest(kind="receive", calibration="receive@1_20260101")), InputError),
    ],
)
def test_an_error_comes_with_its_class_and_its_words(linked, ask, error):
    with pytest.raises(error) as there:
        ask(linked.owned)
    with pytest.raises(error) as here:
        ask(linked.remote)
    assert type(here.value) is type(there.value)
    assert str(here.value) == str(there.value)
    assert here.value.remedy == there.value.remedy


def test_a_job_that_has_ended_cannot_be_paused_nor_answered(linked):
    job = ended(linked, linked.remote.acquire(REQUEST))
    with pytest.raises(DeviceStateError, match="has ended"):
        linked.remote.pause("acquisition", job.identifier)
    with pytest.raises(DeviceStateError, match="does not wait"):
        linked.remote.answer("acquisition", job.identifier)


def test_a_command_is_seen_at_once_whatever_was_asked_a_moment_ago(linked):
    job = linked.remote.acquire(REQUEST.model_copy(update={"shots": 200}))
    linked.remote.job("acquisition", job.identifier)
    linked.remote.outputs_off()
    wait_for(lambda: linked.engine.job("acquisition", job.identifier).state.final)
    assert linked.remote.job("acquisition", job.identifier).state in ("cancelled", "running")
    assert ended(linked, job).state == "cancelled"


def test_every_method_of_the_contract_is_kept_by_both_ends():
    for name in methods():
        assert callable(getattr(RemoteHardware, name))
    assert {"job", "jobs", "acquire", "outputs_off", "status"} <= set(methods())
    assert not {name for name in vars(Hardware) if not name.startswith("_")} - set(methods())


def test_only_this_user_may_connect(linked):
    assert stat.S_IMODE(os.stat(linked.folder / NAME).st_mode) == 0o600


@pytest.fixture
def alone(tmp_path):
    server = LinkServer(lambda: None, tmp_path)
    yield server
    server.close()


def answers(connection):
    line = Line(connection)
    line.send(LinkCall(method=ALIVE, arguments=()))
    answer = line.answer()
    return answer is not None and answer.error is None


def test_a_socket_that_somebody_removed_is_made_anew(alone):
    alone.path.unlink()
    wait_for(alone.path.exists, 5)
    with connected(alone.path, 5) as connection:
        assert answers(connection)


def test_a_folder_that_has_come_in_the_place_of_ours_keeps_its_socket(tmp_path):
    ours, other = tmp_path / "data", tmp_path / "other"
    ours.mkdir()
    server = LinkServer(lambda: None, ours)
    ours.rename(other)
    ours.mkdir()
    another = LinkServer(lambda: None, ours)
    time.sleep(1.5)
    server.close()
    with connected(another.path, 5) as connection:
        assert answers(connection)
    another.close()


def test_without_descriptors_one_waits_and_is_not_the_last_one(alone, monkeypatch):
    accept = socket.socket.accept

    def refuse(self):
        monkeypatch.setattr(socket.socket, "accept", accept)
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    monkeypatch.setattr(socket.socket, "accept", refuse)
    for _ in range(2):
        with connected(alone.path, 5) as connection:
            assert answers(connection)


def test_fifty_that_ask_cost_what_one_does(linked, monkeypatch):
    asked = []
    status = linked.owned.status
    monkeypatch.setattr(linked.owned, "status", lambda: asked.append(1) or status())
    began = time.monotonic()
    threads = [threading.Thread(target=lambda: [linked.remote.status() for _ in range(20)]) for _ in range(50)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert len(asked) <= 2 + (time.monotonic() - began) / 0.05


def test_a_path_longer_than_a_socket_may_have_does_no_harm(tmp_path, linked):
    deep = tmp_path / ("d" * 100) / ("e" * 100)
    deep.mkdir(parents=True)
    server = LinkServer(lambda: linked.owned, deep)
    assert RemoteHardware(deep).status().platform == "simulated platform"
    server.close()


def test_nobody_there_is_an_error_with_a_remedy_and_back_again_is_no_error(tmp_path, linked):
    remote = RemoteHardware(tmp_path, away_s=0.1)
    with pytest.raises(HardwareAway, match="ask again"):
        remote.status()
    for _ in range(2):  # the second time with connections of the first
        server = LinkServer(lambda: linked.owned, tmp_path)
        assert remote.status().platform
        server.close()
        with pytest.raises(HardwareAway, match="has confirmed"):
            remote.outputs_off()


def test_one_that_hangs_is_waited_for_no_longer_than_agreed(tmp_path):
    from platform_daemon.link.address import listening

    silent = listening(tmp_path / NAME)
    with pytest.raises(HardwareAway, match="timed out"):
        RemoteHardware(tmp_path, patience_s=0.2).status()
    silent.close()


@pytest.mark.parametrize(
    "sent", [b"nonsense\n", b"{}\n", b'{"method": "nothing", "arguments": []}\n', b'{"method": "close"', b"\xff\n"]
)
def test_bytes_of_a_stranger_hurt_nobody(linked, sent):
    with connected(linked.folder / NAME, 5) as stranger:
        stranger.sendall(sent)
        stranger.shutdown(socket.SHUT_WR)
        stranger.recv(4096)
    assert linked.remote.status().platform


def test_an_answer_of_before_a_command_is_not_kept():
    recent, goes_on, asked = Recent(), threading.Event(), threading.Event()

    def slowly():
        asked.set()
        goes_on.wait(5)
        return "old"

    asking = threading.Thread(target=recent.answer, args=(("q",), slowly))
    asking.start()
    asked.wait(5)
    recent.forget()
    goes_on.set()
    asking.join()
    assert recent.answer(("q",), lambda: "new") == "new"
