"""Makes a load, in a process of its own so that it does not slow down who measures; bounded in time and number."""

from __future__ import annotations

import http.client
import json
import socket
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass

PREDICTION = {"resonator": "jewel", "windows": [100.0] * 20, "phi_max_rad": 0.7}
DRY_RUN = {"resonator": "jewel", "shots": 1000, "shot_changes": [{"f_tx_hz": 200 + 0.01 * k} for k in range(1000)]}
MEGABYTE = b" " * 1_000_000


@dataclass(frozen=True)
class Load:
    """How many of each.

    Attributes:
        pollers, poll_hz: GET /platform, each so often.
        predictions: that compute for seconds each, all at once and again.
        dry_runs: of a series of 1000 shots that all differ, all at once and again.
        downloads: of a whole file and of its dm/dt, all at once and again.
        half_open: connections that say nothing; those that were dropped are opened again every second.
        diagnoses: of the recording, all at once and again.
        bodies_mb: sizes of bodies that are sent one after the other, again and again.
    """

    pollers: int = 0
    poll_hz: float = 2.0
    predictions: int = 0
    dry_runs: int = 0
    downloads: int = 0
    half_open: int = 0
    diagnoses: int = 0
    bodies_mb: tuple[int, ...] = ()


class Crowd:
    """The clients of a load against a daemon at host and port, for so many seconds; `told` counts what was answered."""

    def __init__(self, port: int, recording: str, seconds: float) -> None:
        self._port, self._recording = port, recording
        self._end = time.monotonic() + seconds
        self.told: Counter[str] = Counter()
        self.polls_s: list[float] = []
        self._lock = threading.Lock()

    def run(self, load: Load) -> None:
        """Returns at the end of the time."""
        work: list[Callable[[], None]] = [
            *(lambda n=n: self._poll(n / load.pollers, 1 / load.poll_hz) for n in range(load.pollers)),
            *(self._predict for _ in range(load.predictions)),
            *(self._dry_run for _ in range(load.dry_runs)),
            *(lambda n=n: self._download(n) for n in range(load.downloads)),
            *(self._diagnose for _ in range(load.diagnoses)),
            *([lambda: self._say_nothing(load.half_open)] if load.half_open else []),
            *([lambda: self._send_bodies(load.bodies_mb)] if load.bodies_mb else []),
        ]
        threads = [threading.Thread(target=each, daemon=True) for each in work]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(max(0.1, self._end + 5 - time.monotonic()))

    @property
    def _goes_on(self) -> bool:
        return time.monotonic() < self._end

    def _tell(self, what: str) -> None:
        with self._lock:
            self.told[what] += 1

    def _ask(self, name: str, method: str, path: str, body: bytes | None = None) -> float:
        """Seconds until the whole answer was there."""
        link = http.client.HTTPConnection("127.0.0.1", self._port, timeout=60)
        began = time.monotonic()
        try:
            headers = {"Content-Type": "application/json"} if body is not None else {}
            link.request(method, path, body, headers)
            answer = link.getresponse()
            while answer.read(1 << 20):
                pass
            self._tell(f"{name} {answer.status}")
        except (OSError, http.client.HTTPException) as error:
            self._tell(f"{name} {type(error).__name__}")
        finally:
            link.close()
        return time.monotonic() - began

    def _poll(self, phase: float, period_s: float) -> None:
        time.sleep(phase * period_s)
        while self._goes_on:
            took = self._ask("poll", "GET", "/platform")
            self.polls_s.append(took)
            time.sleep(max(0.0, period_s - took))

    def _predict(self) -> None:
        body = json.dumps(PREDICTION).encode()
        while self._goes_on:
            self._ask("prediction", "POST", "/predict", body)

    def _dry_run(self) -> None:
        body = json.dumps(DRY_RUN).encode()
        while self._goes_on:
            self._ask("dry run", "POST", "/acquisitions/dry-run", body)

    def _download(self, number: int) -> None:
        whole, part = f"/recordings/{self._recording}/file", f"/recordings/{self._recording}/frames/0/dmdt.npy"
        while self._goes_on:
            self._ask("download", "GET", part if number % 2 else whole)

    def _diagnose(self) -> None:
        body = json.dumps({"recordings": [self._recording]}).encode()
        while self._goes_on:
            self._ask("diagnosis", "POST", "/diagnoses", body)
            time.sleep(20.0)  # each waits for those before it

    def _say_nothing(self, number: int) -> None:
        links: list[socket.socket] = []
        while self._goes_on:
            while len(links) < number and self._goes_on:
                try:
                    link = socket.create_connection(("127.0.0.1", self._port), 1)
                except OSError:
                    break
                link.setblocking(False)
                link.send(b"GET /platform HTTP/1.1\r\nHost:" if len(links) % 2 else b"")
                links.append(link)
                self._tell("half-open connections")
            time.sleep(1.0)
            links = [link for link in links if _is_open(link)]
        for link in links:
            link.close()

    def _send_bodies(self, sizes: tuple[int, ...]) -> None:
        while self._goes_on:
            for number, size in enumerate(sizes):
                self._send_body(size, chunked=number % 2 == 1)

    def _send_body(self, size: int, *, chunked: bool) -> None:
        with socket.create_connection(("127.0.0.1", self._port), 5) as link:
            length = "Transfer-Encoding: chunked" if chunked else f"Content-Length: {size * 1_000_000}"
            head = (
                f"POST /acquisitions HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n{length}\r\n\r\n"
            )
            try:
                link.sendall(head.encode())
                for _ in range(size):
                    link.sendall(b"f4240\r\n%b\r\n" % MEGABYTE if chunked else MEGABYTE)
                if chunked:
                    link.sendall(b"0\r\n\r\n")
                self._tell(f"body {link.recv(12)[9:].decode()}")
            except OSError as error:
                self._tell(f"body {type(error).__name__}")


def _is_open(link: socket.socket) -> bool:
    try:
        closed = link.recv(1) == b""
    except BlockingIOError:
        return True
    except OSError:
        closed = True
    if closed:
        link.close()
    return not closed


def main() -> None:
    """Arguments: port, recording, seconds, the load as JSON; prints what was answered as JSON."""
    port, recording, seconds, text = sys.argv[1:]
    keys = json.loads(text)
    crowd = Crowd(int(port), recording, float(seconds))
    crowd.run(Load(**{**keys, "bodies_mb": tuple(keys["bodies_mb"])}))
    print(json.dumps({"told": crowd.told, "polls_s": crowd.polls_s}))


def arguments(port: int, recording: str, seconds: float, load: Load) -> list[str]:
    """Of the process that makes the load."""
    return [
        sys.executable,
        "-m",
        "tests.campaigns.attack.load",
        str(port),
        recording,
        str(seconds),
        json.dumps(asdict(load)),
    ]


if __name__ == "__main__":
    main()
