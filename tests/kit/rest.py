"""What a client of the REST interface does again and again."""

import time

import httpx2

FINAL = ("done", "failed", "cancelled")


def client_at(address):
    """Asks anew for every request, so that no connection is left from before a process was killed.

    To be kept: a client that is made for one request costs 50 ms of a processor, for the certificates that it loads.
    It waits long: what a request computes has a lower priority than the tests beside it, and may get a fifteenth of a
    processor.
    """
    return httpx2.Client(base_url=address, timeout=240, limits=httpx2.Limits(max_keepalive_connections=0))


def finished(client, location):
    """The job at `location`, once it has ended; the longer that takes, the less often it is asked for.

    Analyses have a lower priority than the tests beside them: ten seconds of a processor can take three minutes.
    """
    begun = time.monotonic()
    while time.monotonic() < begun + 600:
        job = client.get(location).json()
        if job["state"] in FINAL:
            return job
        time.sleep(min(0.3, max(0.02, 0.1 * (time.monotonic() - begun))))
    raise AssertionError(f"{location} did not end")


def pages(client, path, limit=None):
    """Every page of a list from the first one on."""
    link = path if limit is None else f"{path}?limit={limit}"
    while link is not None:
        answer = client.get(link)
        assert answer.status_code == 200, answer.text
        page = answer.json()
        link = answer.links.get("next", {}).get("url")
        assert page["next"] == link
        yield page


def problem(answer, status):
    """The body of an answer, which must be a problem (RFC 9457) with that status."""
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    body = answer.json()
    assert body["status"] == status
    assert body["title"]
    return body
