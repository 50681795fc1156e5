"""Calls somebody: a command that is run, or a URL that is posted to, with the alarm as JSON."""

from __future__ import annotations

import queue
import shlex
import subprocess
import threading

import httpx2
import structlog

from drivers.errors import ConfigError
from platform_daemon.schemas import Alarm, to_json

log = structlog.get_logger()
_PATIENCE_S = 30.0
MOST_WAITING = 100


class Caller:
    """One after the other, in a thread of its own: who raises an alarm waits for nobody.

    command: words as a shell splits them, gets the alarm as JSON on standard input; url: is sent it by POST; None:
    neither.  Raises ConfigError for a command without words, or a URL that is not HTTP.
    """

    def __init__(self, command: str | None = None, url: str | None = None) -> None:
        try:
            self._words = shlex.split(command) if command else []
        except ValueError as error:
            raise ConfigError(f"cannot be split: {error}", where="--alarm-command", remedy="close quotes") from None
        if url is not None and not url.startswith(("http://", "https://")):
            raise ConfigError("is no URL of HTTP", where="--alarm-url", remedy="begin it with http:// or https://")
        self._url = url
        self._waiting: queue.Queue[Alarm] = queue.Queue(MOST_WAITING)
        if self._words or self._url:
            threading.Thread(target=self._work, name="alarm-calls", daemon=True).start()

    def __call__(self, alarm: Alarm) -> None:
        """Call for this one, soon."""
        if not self._words and not self._url:
            return
        try:
            self._waiting.put_nowait(alarm)
        except queue.Full:
            log.error("alarm_not_called", alarm=alarm.name, why=f"{MOST_WAITING} calls wait")

    def _work(self) -> None:
        while True:
            alarm = self._waiting.get()
            text = to_json(alarm).encode()
            for call in (self._run, self._post):  # each, whatever became of the other
                try:
                    call(text)
                except (OSError, subprocess.SubprocessError, httpx2.HTTPError, httpx2.InvalidURL) as error:
                    log.error("alarm_call_failed", alarm=alarm.name, error=str(error) or type(error).__name__)

    def _run(self, text: bytes) -> None:
        if self._words:
            subprocess.run(self._words, input=text, stdout=subprocess.DEVNULL, timeout=_PATIENCE_S, check=True)

    def _post(self, text: bytes) -> None:
        if self._url:
            headers = {"Content-Type": "application/json"}
            # What it answers is not read: it may never end.
            with httpx2.stream("POST", self._url, content=text, headers=headers, timeout=_PATIENCE_S) as answer:
                answer.raise_for_status()
