"""Signs of life of a process: one that is there and does nothing is as bad as none.

A process that hangs while power may be on is ended by its guard.  This is for all others, which nobody else ends.
"""

from __future__ import annotations

import os
import select
import threading
import time

BEAT = b"."
EVERY_S = 0.5
HANGS_S = 15.0  # a busy or swapping computer lets a thread that writes a byte wait for seconds, not for so long
_LONGEST_LOOK_S = 2.0
_LONGEST_WORDS = 4096


def beat(pipe: int) -> None:
    """From now on say that this process lives, in a thread of its own."""
    os.set_blocking(pipe, False)  # whoever listens may be halted: that must not halt us
    threading.Thread(target=_beat, args=(pipe,), name="pulse", daemon=True).start()


def _beat(pipe: int) -> None:
    while True:
        try:
            os.write(pipe, BEAT)
        except BlockingIOError:
            pass
        except OSError:  # nobody listens any more
            return
        time.sleep(EVERY_S)


class Pulse:
    """The parent's end: how long the process has said nothing.

    start_s: how long it may be silent before its first beat, s.
    """

    def __init__(self, pipe: int, start_s: float) -> None:
        self._pipe, self._start_s = pipe, start_s
        self._silent_s, self._looked_s = 0.0, time.monotonic()
        self._begun = False
        self._words = b""

    def begin(self) -> None:
        """Its start is over: the first beat may be no later than all others."""
        self._begun = True

    def stopped(self) -> bool:
        """Has it been silent for too long, since the last time that this was so?  To be asked about every second.

        Only time in which the parent itself ran is counted: a computer that slept has put all of them to sleep.
        """
        now_s = time.monotonic()
        self._silent_s += min(now_s - self._looked_s, _LONGEST_LOOK_S)
        self._looked_s = now_s
        said = self._hear()
        if said:
            self._silent_s = 0.0
            self._begun = self._begun or said.endswith(BEAT)
        if self._silent_s <= (HANGS_S if self._begun else self._start_s):
            return False
        self._silent_s = 0.0
        return True

    def last_words(self) -> bytes:
        """The last that was said, beats among it."""
        self._hear()
        return self._words

    def _hear(self) -> bytes:
        said = b""
        while select.select([self._pipe], [], [], 0)[0] and (part := os.read(self._pipe, 4096)):
            said += part
        self._words = (self._words + said)[-_LONGEST_WORDS:]
        return said
