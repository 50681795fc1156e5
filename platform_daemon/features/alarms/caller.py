"""Notification of a person: runs a command, or posts to a URL, with the alarm as JSON."""

from __future__ import annotations

import heapq
import itertools
import queue
import shlex
import subprocess
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import httpx2
import structlog

from drivers.errors import ConfigError
from platform_daemon.core.schemas.base import to_json

from .schema import Alarm

log = structlog.get_logger()
_PATIENCE_S = 30.0
MOST_WAITING = 100
AGAIN_AFTER_S = (10.0, 60.0, 300.0, *[900.0] * 95)
"""What could not be delivered is tried again after each of these, s: for a day."""
_numbers = itertools.count()


@dataclass(order=True)
class _Call:
    """One to make: at, s of the monotonic clock; tried: how often it has failed."""

    at_s: float
    number: int
    alarm: Alarm = field(compare=False)
    how: Callable[[bytes], None] = field(compare=False)
    tried: int = field(compare=False, default=0)


class Caller:
    """Sends notifications one after the other in its own thread, so that raising an alarm never waits.

    command: words as a shell splits them, gets the alarm as JSON on standard input; url: is sent it by POST; None:
    neither.  again_after_s: a call that failed is made again after each of these.  Raises ConfigError for a command
    without words, or a URL that is not HTTP.
    """

    def __init__(
        self, command: str | None = None, url: str | None = None, again_after_s: tuple[float, ...] = AGAIN_AFTER_S
    ) -> None:
        try:
            self._words = shlex.split(command or "")
        except ValueError as error:
            raise ConfigError(f"cannot be split: {error}", where="--alarm-command", remedy="close quotes") from None
        if command is not None and not self._words:
            remedy = "name a program, or leave the option out"
            raise ConfigError("names no command", where="--alarm-command", remedy=remedy)
        if url is not None and not url.startswith(("http://", "https://")):
            raise ConfigError("is no URL of HTTP", where="--alarm-url", remedy="begin it with http:// or https://")
        self._url, self._again_after_s = url, again_after_s
        self._waiting: queue.Queue[Alarm] = queue.Queue(MOST_WAITING)
        self._calls: list[_Call] = []  # a heap, of the thread only
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
            self._take()
            if self._calls and self._calls[0].at_s <= time.monotonic():
                self._make(heapq.heappop(self._calls))

    def _take(self) -> None:
        """An alarm that is new; waits for one until the next call is to be made."""
        wait_s = max(0.0, self._calls[0].at_s - time.monotonic()) if self._calls else None
        try:
            alarm = self._waiting.get(timeout=wait_s)
        except queue.Empty:
            return
        ways = [how for given, how in ((self._words, self._run), (self._url, self._post)) if given]
        for how in ways:  # each, whatever becomes of the other
            self._keep(_Call(time.monotonic(), next(_numbers), alarm, how))

    def _make(self, call: _Call) -> None:
        try:
            call.how(to_json(call.alarm).encode())
        except Exception as error:  # whatever it is: a name that is none must not end the calls of all other alarms
            over = call.tried == len(self._again_after_s)
            again_s = None if over else self._again_after_s[call.tried]
            why = str(error) or type(error).__name__
            log.error("alarm_call_failed", alarm=call.alarm.name, error=why, again_after_s=again_s)
            if again_s is not None:
                self._keep(_Call(time.monotonic() + again_s, next(_numbers), call.alarm, call.how, call.tried + 1))

    def _keep(self, call: _Call) -> None:
        """Of too many that wait, those that have failed most often are given up."""
        heapq.heappush(self._calls, call)
        if len(self._calls) > 2 * MOST_WAITING:
            given_up = max(self._calls, key=lambda each: (each.tried, -each.number))
            self._calls.remove(given_up)
            heapq.heapify(self._calls)
            log.error("alarm_not_called", alarm=given_up.alarm.name, why=f"{2 * MOST_WAITING} calls wait")

    def _run(self, text: bytes) -> None:
        subprocess.run(self._words, input=text, stdout=subprocess.DEVNULL, timeout=_PATIENCE_S, check=True)

    def _post(self, text: bytes) -> None:
        """In a thread, which is left alone where the head of the answer, byte by byte, takes for ever."""
        failed: list[Exception] = []
        with httpx2.Client(timeout=_PATIENCE_S) as client:  # its end lets go of the connection
            thread = threading.Thread(target=self._posted, args=(client, text, failed), name="alarm-url", daemon=True)
            thread.start()
            thread.join(2 * _PATIENCE_S)
            if thread.is_alive():
                raise TimeoutError(f"no answer within {2 * _PATIENCE_S:g} s")
        if failed:
            raise failed[0]

    def _posted(self, client: httpx2.Client, text: bytes, failed: list[Exception]) -> None:
        headers = {"Content-Type": "application/json"}
        try:
            # What it answers is not read: it may never end.
            with client.stream("POST", str(self._url), content=text, headers=headers) as answer:
                answer.raise_for_status()
        except Exception as error:  # for who waits
            failed.append(error)
