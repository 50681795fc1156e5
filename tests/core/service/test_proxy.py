"""What crosses the socket is what is on the other side of it, errors too."""

import errno
import inspect
import os
import shutil
import socket
import stat
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from drivers.errors import DeviceStateError, InputError, SequenceRejected
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.schemas.requests import AcquisitionRequest, ActivationRequest, CalibrationRequest
from platform_daemon.core.schemas.rpc import RpcCall
from platform_daemon.core.service import response_cache
from platform_daemon.core.service.address import NAME, connected
from platform_daemon.core.service.errors import HardwareAway
from platform_daemon.core.service.framing import ALIVE, JsonLineConnection
from platform_daemon.core.service.local import LocalPlatformService
from platform_daemon.core.service.platform_service import PlatformService
from platform_daemon.core.service.proxy import PlatformServiceProxy
from platform_daemon.core.service.response_cache import ResponseCache
from platform_daemon.core.service.server import LinkServer
from platform_daemon.core.service.wire import methods, services
from platform_daemon.core.state.errors import StorageError, StorageUnusable
from platform_daemon.features.fit.request_schema import RecordingFitRequest
from platform_daemon.features.schedules.contract import ScheduleService
from platform_daemon.features.schedules.schedules import Schedules
from platform_daemon.features.schedules.schema import ScheduleRequest
from platform_daemon.features.self_test.schema import SelfTestRequest
from platform_daemon.features.sweep.schema import SweepRequest
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for

REQUEST = AcquisitionRequest.model_validate(SHORT_JEWEL)


def told(linked, method, *arguments):
    """The answer to a call as it stands on the wire."""
    with connected(linked.folder / NAME, 5) as connection:
        line = JsonLineConnection(connection)
        line.send(RpcCall(method=method, arguments=arguments))
        return line.answer()


def ended(linked, job):
    wait_for(lambda: linked.remote.job(job.kind, job.identifier).state.final)
    return linked.remote.job(job.kind, job.identifier)


def test_a_series_is_the_same_on_both_sides(linked):
    job = linked.remote.submit("acquisition", REQUEST)
    assert job.request == REQUEST
    done = ended(linked, job)
    assert done == linked.owned.job("acquisition", job.identifier)
    assert done.result.recording == job.identifier
    assert job.identifier in linked.remote.job_ids("acquisition")
    assert linked.remote.jobs("acquisition", (job.identifier,)) == (done,)
    assert linked.remote.last_harmonics() == linked.engine.live.latest


def test_state_and_plans_are_the_same_on_both_sides(linked):
    assert linked.remote.status().platform == linked.engine.status().platform
    assert len(linked.remote.devices().items) == len(linked.engine.devices().items)
    assert linked.remote.warm().keys() == linked.engine.warm.keys()
    assert linked.remote.dry_run("acquisition", REQUEST) == linked.owned.dry_run("acquisition", REQUEST)
    sweep = SweepRequest.model_validate(
        {"kind": "sweep", "acquisition": SHORT_JEWEL, "over": [{"key": "field_ut", "values": [100.0, 200.0]}]}
    )
    assert linked.remote.dry_run("procedure", sweep) == linked.owned.dry_run("procedure", sweep)


def test_a_calibration_that_the_disk_could_not_keep_moves_nothing(linked, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=1000))
    before = linked.owned.job_ids("calibration")
    with pytest.raises(StorageUnusable, match=r"calibrations.*Remedy: free the disk"):
        linked.remote.submit("calibration", CalibrationRequest(kind="receive"))
    assert linked.owned.job_ids("calibration") == before


@pytest.mark.parametrize(
    ("ask", "error"),
    [
        (lambda r: r.job("acquisition", "nothing"), UnknownId),
        (lambda r: r.cancel("acquisition", "nothing"), UnknownId),
        (lambda r: r.submit("acquisition", REQUEST.model_copy(update={"resonator": "/etc/passwd"})), InputError),
        (
            lambda r: r.submit(
                "acquisition", AcquisitionRequest.model_validate({**SHORT_JEWEL, "sequence": {"field_t": 5e-3}})
            ),
            SequenceRejected,
        ),
        (lambda r: r.submit("fit", RecordingFitRequest(recording="a")), InputError),
        (lambda r: r.dry_run("self_test", SelfTestRequest()), InputError),
        (lambda r: r.submit("walk", REQUEST), InputError),
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
    job = ended(linked, linked.remote.submit("acquisition", REQUEST))
    with pytest.raises(DeviceStateError, match="has ended"):
        linked.remote.pause("acquisition", job.identifier)
    with pytest.raises(DeviceStateError, match="does not wait"):
        linked.remote.answer("acquisition", job.identifier)


def test_a_command_is_seen_at_once_whatever_was_asked_a_moment_ago(linked):
    job = linked.remote.submit("acquisition", REQUEST.model_copy(update={"shots": 200}))
    linked.remote.job("acquisition", job.identifier)
    linked.remote.outputs_off()
    wait_for(lambda: linked.engine.job("acquisition", job.identifier).state.final)
    assert linked.remote.job("acquisition", job.identifier).state in ("cancelled", "running")
    assert ended(linked, job).state == "cancelled"


def test_every_method_of_the_contract_is_kept_by_both_ends():
    assert services() == {"": PlatformService, "schedules": ScheduleService}
    owners = {"": LocalPlatformService, "schedules": Schedules}
    remote, expected = PlatformServiceProxy(Path("nowhere")), set()
    for service, contract in services().items():
        here = remote.service(service) if service else remote
        for name in (each for each in dir(contract) if not each.startswith("_")):
            expected.add(f"{service}.{name}" if service else name)
            assert callable(getattr(here, name))
            asked = [*inspect.signature(getattr(contract, name)).parameters]
            answering = inspect.signature(getattr(owners[service], name)).parameters.values()
            assert [each.name for each in answering][: len(asked)] == asked
            assert all(each.default is not each.empty for each in [*answering][len(asked) :])
            if inspect.isfunction(written := inspect.getattr_static(here, name, None)):
                assert [*inspect.signature(written).parameters] == asked
    assert methods().keys() == expected
    assert {"job", "jobs", "submit", "outputs_off", "status", "schedules.add"} <= expected


@pytest.mark.parametrize("name", ["engine", "take_up_queue", "_registry", "walk"])
def test_what_is_in_no_contract_is_offered_by_neither_end(linked, name):
    with pytest.raises(AttributeError):
        getattr(linked.remote, name)
    with pytest.raises(AttributeError):
        getattr(linked.remote.service("schedules"), name)
    for method in (name, f"schedules.{name}", f"nothing.{name}"):
        answer = told(linked, method)
        assert answer.error is not None
        assert answer.value is None


@pytest.mark.parametrize(
    ("method", "arguments"),
    [
        ("job", ("acquisition",)),
        ("job", ("acquisition", 3)),
        ("jobs", ("acquisition", "acquisition-1")),
        ("shots", ("acquisition", "acquisition-1", "first", 10)),
        ("submit", ("acquisition", {"resonator": "jewel", "shots": "many"})),
        ("submit", ("acquisition", {"recording": "a"})),
        ("submit", ("walk", {"resonator": "jewel"})),
        ("unlock", ({"by": ["me"]},)),
    ],
)
def test_arguments_of_other_types_reach_no_service(linked, monkeypatch, method, arguments):
    reached = []
    monkeypatch.setattr(linked.owned, method, lambda *given: reached.append(given))
    answer = told(linked, method, *arguments)
    assert answer.error is not None
    assert answer.value is None
    assert reached == []


def test_a_kind_that_no_feature_has_has_no_list_of_jobs(linked):
    for service in (linked.remote, linked.owned):
        with pytest.raises(InputError, match=r"no job is of the kind 'walk'.*one of: acquisition"):
            service.job_ids("walk")


class Calendar:
    """What the schedules of a hardware process answer."""

    def __init__(self):
        self.asked = []

    def preview(self, request, count):
        self.asked.append((request, count))
        return ("2026-11-27T02:00:00+00:00",) * count

    def list(self):
        return ()


def test_the_service_of_a_feature_is_asked_by_its_name(tmp_path, linked):
    calendar = Calendar()
    server = LinkServer({"schedules": calendar, "": linked.owned}.__getitem__, tmp_path)
    remote = PlatformServiceProxy(tmp_path)
    work = {"kind": "acquisition", "request": SHORT_JEWEL}
    request = ScheduleRequest.model_validate({"name": "nightly", "trigger": {"every_s": 3600.0}, "work": work})
    assert remote.service("schedules").preview(request, 2) == ("2026-11-27T02:00:00+00:00",) * 2
    assert calendar.asked == [(request, 2)]
    assert remote.service("schedules").list() == ()
    assert remote.status().platform == "simulated platform"
    remote.close()
    server.close()


def test_what_the_service_of_a_feature_raises_comes_with_its_class_and_its_words(linked):
    with pytest.raises(StorageError, match=r"no schedules here.*Remedy: ask a daemon"):
        linked.remote.service("schedules").list()


def test_a_job_that_has_ended_is_asked_for_once_until_it_is_resumed(linked, monkeypatch):
    job = ended(linked, linked.remote.submit("acquisition", REQUEST))
    asked, jobs = [], linked.owned.jobs
    monkeypatch.setattr(linked.owned, "jobs", lambda kind, names: asked.append(names) or jobs(kind, names))
    for _ in range(3):
        linked.remote.invalidate()
        assert linked.remote.job("acquisition", job.identifier) == job
    assert asked == []
    other = linked.remote.submit("acquisition", REQUEST)
    assert [each.identifier for each in linked.remote.jobs("acquisition", (other.identifier, job.identifier))] == [
        other.identifier,
        job.identifier,
    ]
    assert asked == [(other.identifier,)]
    with pytest.raises(DeviceStateError):  # all its shots are there
        linked.remote.resume("acquisition", job.identifier)
    linked.remote.job("acquisition", job.identifier)
    assert asked[-1] == (job.identifier,)
    ended(linked, other)


def test_a_check_is_made_each_time_and_leaves_answers_as_they_are(linked, monkeypatch):
    asked, dry_run, status = [], linked.owned.dry_run, linked.owned.status
    monkeypatch.setattr(linked.owned, "dry_run", lambda *given: asked.append("dry_run") or dry_run(*given))
    monkeypatch.setattr(linked.owned, "status", lambda: asked.append("status") or status())
    monkeypatch.setattr(response_cache, "RECENT_S", 60.0)
    linked.remote.invalidate()
    for _ in range(2):
        linked.remote.status()
        linked.remote.dry_run("acquisition", REQUEST)
    assert asked == ["status", "dry_run", "dry_run"]
    with pytest.raises(UnknownId):
        linked.remote.cancel("acquisition", "nothing")  # a command invalidates them even if it is refused
    linked.remote.status()
    assert asked == ["status", "dry_run", "dry_run", "status"]


def test_only_this_user_may_connect(linked):
    assert stat.S_IMODE(os.stat(linked.folder / NAME).st_mode) == 0o600


@pytest.fixture
def alone(tmp_path):
    server = LinkServer(lambda name: None, tmp_path)
    yield server
    server.close()


def answers(connection):
    line = JsonLineConnection(connection)
    line.send(RpcCall(method=ALIVE, arguments=()))
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
    server = LinkServer(lambda name: None, ours)
    ours.rename(other)
    ours.mkdir()
    another = LinkServer(lambda name: None, ours)
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
    server = LinkServer(lambda name: linked.owned, deep)
    assert PlatformServiceProxy(deep).status().platform == "simulated platform"
    server.close()


def test_nobody_there_is_an_error_with_a_remedy_and_back_again_is_no_error(tmp_path, linked):
    remote = PlatformServiceProxy(tmp_path, away_s=0.1)
    with pytest.raises(HardwareAway, match="repeat the request"):
        remote.status()
    for _ in range(2):  # the second time with connections of the first
        server = LinkServer(lambda name: linked.owned, tmp_path)
        assert remote.status().platform
        server.close()
        with pytest.raises(HardwareAway, match="has confirmed"):
            remote.outputs_off()


def test_one_that_hangs_is_waited_for_no_longer_than_agreed(tmp_path):
    from platform_daemon.core.service.address import listening

    silent = listening(tmp_path / NAME)
    with pytest.raises(HardwareAway, match="timed out"):
        PlatformServiceProxy(tmp_path, patience_s=0.2).status()
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
    recent, goes_on, asked = ResponseCache(), threading.Event(), threading.Event()

    def slowly():
        asked.set()
        goes_on.wait(5)
        return "old"

    asking = threading.Thread(target=recent.answer, args=(("q",), slowly))
    asking.start()
    asked.wait(5)
    recent.invalidate()
    goes_on.set()
    asking.join()
    assert recent.answer(("q",), lambda: "new") == "new"
