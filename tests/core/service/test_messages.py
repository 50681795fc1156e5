"""What is sent over the socket: how often it is serialised, and what a process says that does not understand it."""

import json
import threading

import pytest
from pydantic import BaseModel, TypeAdapter

from platform_daemon.core.schemas.rpc import RpcAnswer, RpcCall
from platform_daemon.core.service.address import NAME, connected
from platform_daemon.core.service.errors import ProcessesDiffer
from platform_daemon.core.service.framing import JsonLineConnection
from platform_daemon.core.service.proxy import PlatformServiceProxy
from platform_daemon.core.service.server import LinkServer
from tests.kit.acquisitions import SHORT_JEWEL

JSON = {"Content-Type": "application/json"}


def answer_to(linked, method, *arguments):
    """The answer to a call as it stands on the wire."""
    with connected(linked.folder / NAME, 5) as connection:
        line = JsonLineConnection(connection)
        line.send(RpcCall(method=method, arguments=arguments))
        return line.answer()


def test_a_call_of_another_version_is_answered_with_what_where_why_and_remedy(linked):
    for method, arguments in (("submit", ("acquisition", {"resonator": "jewel", "far": 1})), ("walk", ())):
        error = answer_to(linked, method, *arguments).error
        assert error is not None
        assert error.kinds[0] == "ProcessesDiffer"
        assert error.where == f"hardware.sock: {method}"
        assert error.why
        assert "start it again" in error.remedy
        assert "\n" not in error.why
    assert "far" in answer_to(linked, "submit", "acquisition", {"resonator": "jewel", "far": 1}).error.why


@pytest.mark.parametrize(
    "call",
    [lambda r: r.status(), lambda r: r.job("acquisition", "acquisition-1"), lambda r: r.job_ids("acquisition")],
    ids=["status", "job", "job_ids"],
)
def test_an_answer_of_another_version_is_an_error_with_what_where_why_and_remedy(tmp_path, monkeypatch, call):
    monkeypatch.setattr(LinkServer, "_answer", lambda server, call: RpcAnswer(value={"another": 1}, error=None))
    server = LinkServer(lambda name: None, tmp_path)
    remote = PlatformServiceProxy(tmp_path)
    with pytest.raises(ProcessesDiffer, match="start it again") as refused:
        call(remote)
    assert refused.value.where.startswith("hardware.sock: ")
    assert refused.value.why
    remote.close()
    server.close()


MARK = "counted-operator"
SERIALISE = {json: ["dumps"], BaseModel: ["model_dump_json"], TypeAdapter: ["dump_json"]}
PARSE = {json: ["loads"], BaseModel: ["model_validate_json"], TypeAdapter: ["validate_json"]}


@pytest.fixture
def messages(monkeypatch):
    """Every text with the mark that is made, and every one that is read, but for what the hardware thread does."""
    made, read = [], []

    def watch(owner, name, seen, text_of):
        before = vars(owner)[name]
        original = before.__func__ if isinstance(before, classmethod) else before

        def watched(*arguments, **keys):
            found = original(*arguments, **keys)
            text = text_of(arguments, found)
            text = text.decode() if isinstance(text, bytes) else str(text)
            if MARK in text and threading.current_thread().name != "hardware":
                seen.append(text)
            return found

        monkeypatch.setattr(owner, name, classmethod(watched) if isinstance(before, classmethod) else watched)

    for owner, names in SERIALISE.items():
        for name in names:
            watch(owner, name, made, lambda arguments, found: found)
    for owner, names in PARSE.items():
        for name in names:
            watch(owner, name, read, lambda arguments, found: arguments[-1])
    return made, read


@pytest.mark.parametrize("path", ["/acquisitions", "/self-tests"])
def test_a_request_is_serialised_four_times_and_parsed_three_times_before_its_answer(client, messages, path):
    """Call, record on the disk, answer, response; body, call, answer.  Each is made from the model, or made to it."""
    made, read = messages
    content = {**SHORT_JEWEL, "shots": 1} if path == "/acquisitions" else {}
    answer = client.post(path, content=json.dumps({**content, "operator": MARK}), headers=JSON)
    assert answer.status_code == 202
    made.pop(0)  # of the client
    assert [shape(text) for text in made] == ["call", "record", "answer", "response"]
    assert [shape(text) for text in read] == ["body", "call", "answer"]
    client.delete(answer.headers["location"])


def shape(text):
    """Which message a text is."""
    keys = json.JSONDecoder().decode(text).keys()
    first = {"method": "call", "value": "answer", "links": "response", "id": "record", "operator": "body"}
    return next(name for key, name in first.items() if key in keys)
