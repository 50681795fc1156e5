"""What a client of the REST interface does again and again."""

import time

FINAL = ("done", "failed", "cancelled")


def finished(client, location):
    """The job at `location`, once it has ended."""
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline:
        job = client.get(location).json()
        if job["state"] in FINAL:
            return job
        time.sleep(0.05)
    raise AssertionError(f"{location} did not end")


def pages(client, path, limit=None):
    """Every page of a list from the first one on."""
    link = path if limit is None else f"{path}?limit={limit}"
    while link is not None:
        answer = client.get(link)
        assert answer.status_code == 200, answer.text
        yield answer.json()
        link = answer.links.get("next", {}).get("url")


def problem(answer, status):
    """The body of an answer, which must be a problem (RFC 9457) with that status."""
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    body = answer.json()
    assert body["status"] == status
    assert body["title"]
    return body
