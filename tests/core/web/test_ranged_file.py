"""Ranges of a file (RFC 9110, 14): what is understood is answered, what is not is ignored."""

import base64
import hashlib

import pytest

from platform_daemon.core.web.ranged_file import within
from tests.kit.rest import problem


@pytest.fixture(scope="module")
def file(client, recording):
    """Its path, and what it holds."""
    path = f"/recordings/{recording}/file"
    return path, client.get(path).content


def test_parts_are_sent(client, file):
    path, whole = file
    n = len(whole)
    for asked, part in (("0-9", whole[:10]), ("-7", whole[-7:]), (f"{n - 3}-", whole[-3:]), (f"5-{n * 9}", whole[5:])):
        answer = client.get(path, headers={"Range": f"bytes={asked}"})
        assert (answer.status_code, answer.content) == (206, part), asked
        assert answer.headers["content-range"].endswith(f"/{n}")
    several = client.get(path, headers={"Range": "Bytes=0-9, 20-29"})
    assert several.status_code == 206
    assert several.headers["content-type"].startswith("multipart/byteranges")
    assert several.content.count(b"Content-Range") == 2


def test_of_parts_of_which_some_are_not_there_the_others_are_sent(client, file):
    path, whole = file
    answer = client.get(path, headers={"Range": f"bytes={len(whole)}-, 0-9"})
    assert (answer.status_code, answer.content) == (206, whole[:10])


@pytest.mark.parametrize("asked", ["bytes=999999999999-", "bytes=-0", f"bytes={'9' * 90}-,{'9' * 90}-"])
def test_what_is_not_there_is_a_problem_that_says_how_long_the_file_is(client, file, asked):
    path, whole = file
    answer = client.get(path, headers={"Range": asked})
    assert answer.headers["content-range"] == f"bytes */{len(whole)}"
    said = problem(answer, 416)
    assert (said["type"], said["where"]) == ("/problems/range-not-satisfiable", "Range")
    assert str(len(whole) - 1) in said["remedy"]
    assert client.get(said["type"]).status_code == 200


def test_of_head_a_range_is_ignored(client, file):
    path, whole = file
    answer = client.head(path, headers={"Range": "bytes=0-9"})
    assert (answer.status_code, answer.headers["content-length"]) == (200, str(len(whole)))


@pytest.mark.parametrize(
    "asked", ["lines=0-1", "bytes=a-b", "bytes=", "bytes", "bytes=5-2", "bytes=0-1,x", "bytes=+1-2", "bytes=-", "=0-1"]
)
def test_what_is_no_range_of_bytes_is_ignored(client, file, asked):
    path, whole = file
    answer = client.get(path, headers={"Range": asked})
    assert (answer.status_code, answer.content) == (200, whole)


def test_a_range_of_another_version_is_ignored_whether_it_is_there_or_not(client, file):
    path, whole = file
    for asked in ("bytes=0-9", "bytes=999999999999-"):
        answer = client.get(path, headers={"Range": asked, "If-Range": '"another"'})
        assert (answer.status_code, answer.content) == (200, whole)


def test_head_says_how_long_the_file_is(client, file):
    path, whole = file
    answer = client.head(path)
    assert (answer.content, answer.headers["content-length"]) == (b"", str(len(whole)))


def test_a_long_one_takes_no_time():
    assert within("bytes=" + "0-1 , " * 5000 + "x", 10) is None
    assert within("bytes=" + " " * 30_000 + "x", 10) is None


def test_the_schema_of_every_file_has_both_statuses(client):
    paths = client.get("/openapi.json").json()["paths"]
    files = [p for p in paths if p.endswith(("/file", "/report"))]
    assert len(files) == 5
    for path in files:
        assert {"206", "416"} <= set(paths[path]["get"]["responses"]), path


def test_the_sha_256_of_the_whole_file_is_sent_with_each_part_where_it_is_asked_for(client, recording):
    path = f"/recordings/{recording}/file"
    whole = client.get(path)
    assert "repr-digest" not in whole.headers
    digest = base64.b64encode(hashlib.sha256(whole.content).digest()).decode()
    for more in ({}, {"Range": "bytes=5-9"}):
        answer = client.get(path, headers={"Want-Repr-Digest": "sha-256=10", **more})
        assert answer.headers["repr-digest"] == f"sha-256=:{digest}:"
