"""`platform-daemon serve` as a process, asked over HTTP; every answer is kept."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import time
from types import TracebackType
from typing import Any

import httpx2

from tests.system.golden.structure import body_structure
from tests.system.golden.workplace import TIMEOUT_S, Workplace

FINAL = ("done", "failed", "cancelled")
_HEADERS = ("content-type", "location", "content-disposition", "allow")
# Of a job that has only just begun, or is about to end, these depend on when they were asked for.
_RACING = ("state", "question", "phase", "done", "fraction", "started", "finished", "time_left_s", "result", "links")


class Daemon:
    """A daemon on the simulated platform with `data` in the workplace; ends with the `with` block.

    routes: how the live schema names its routes.
    """

    def __init__(self, place: Workplace, *options: str) -> None:
        self._place = place
        self._asked: set[tuple[str, str]] = set()
        self._log = (place.folder / "daemon.log").open("a")
        self._process = subprocess.Popen(
            place.command("serve", "--port", "0", "--data", "data", *options),
            stdout=subprocess.PIPE, stderr=self._log, text=True, cwd=place.folder, env=place.environment,
        )  # fmt: skip
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line.startswith("listening on "):
            raise RuntimeError(f"the daemon did not start: {(place.folder / 'daemon.log').read_text()}")
        self._http = httpx2.Client(base_url=line.split()[-1], timeout=TIMEOUT_S)
        while self._http.get("/ready").status_code == 503:
            time.sleep(0.1)

    def __enter__(self) -> Daemon:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._http.close()
        self._process.send_signal(signal.SIGTERM)
        self._process.wait(timeout=60)
        self._log.close()

    def ask(self, name: str, method: str, path: str, *, racing: bool = False, **request: Any) -> Any:
        """Keep an answer as `NAME.txt` (status and headers) and `NAME.json` (body); the body.

        racing: of a job that goes on meanwhile; only what does not depend on the moment is kept.
        """
        answer = self._http.request(method, path, **request)
        self._asked.add((method, answer.request.url.path))
        told = [f"{k}: {answer.headers[k]}" for k in _HEADERS if k in answer.headers]
        asked = f"{method} {answer.request.url.raw_path.decode()}"
        media_type = answer.headers.get("content-type", "")
        head = "\n".join([asked, str(answer.status_code), *told]) + "\n"
        if "json" not in media_type:
            self._place.keep(f"{name}.txt", head + body_structure(answer.content, media_type))
            return answer.content
        self._place.keep(f"{name}.txt", head)
        body = answer.json()
        self._place.keep(f"{name}.json", _settled(body) if racing else answer.text)
        return body

    def job(self, name: str, path: str, body: dict[str, Any]) -> dict[str, Any]:
        """Start a job, wait for its end, and keep both answers, as NAME-asked and NAME; the ended job."""
        # Identifiers hold the second: with one each, files are listed in the order in which they were made.
        time.sleep(1.0 - time.time() % 1.0)
        started = self.ask(f"{name}-asked", "POST", path, json=body, racing=True)
        self.wait(started["links"]["self"], *FINAL)
        ended: dict[str, Any] = self.ask(name, "GET", started["links"]["self"])
        return ended

    def wait(self, path: str, *states: str) -> None:
        """Until the job there is in one of these states."""
        end = time.monotonic() + TIMEOUT_S
        while (job := self._http.get(path).json())["state"] not in states:
            if time.monotonic() > end or job["state"] in FINAL:
                raise RuntimeError(f"{path} is not {' or '.join(states)} but {job['state']}: {job['error']}")
            time.sleep(0.02)

    def settle(self) -> None:
        """Until the devices have been read back after the last job, as they are every second."""
        time.sleep(2.0)

    def routes(self) -> dict[str, bool]:
        """Every route of the live schema, as `GET /fits/{identifier}`: has it been asked for?"""
        paths = self._http.get("/openapi.json").json()["paths"]
        known = [(m.upper(), template) for template in paths for m in paths[template]]
        met = {_route(method, path, known) for method, path in self._asked}
        return {" ".join(route): route in met for route in sorted(known)}


def _route(method: str, path: str, known: list[tuple[str, str]]) -> tuple[str, str] | None:
    """The route that answers a path: the one with the fewest parameters."""
    fitting = [r for r in known if r[0] == method and re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", r[1]), path)]
    return min(fitting, key=lambda r: r[1].count("{"), default=None)


def _settled(body: dict[str, Any]) -> str:
    """The body, in the separators that the API uses, with placeholders for what races."""

    def settle(value: Any) -> Any:
        if isinstance(value, dict):
            return {k: "<racing>" if k in _RACING else settle(v) for k, v in value.items()}
        return value

    kept = settle(body) | ({"links": {"self": body["links"]["self"]}} if "links" in body else {})
    return json.dumps(kept, ensure_ascii=False, separators=(",", ":"))
