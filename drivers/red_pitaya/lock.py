"""One daemon per card on this computer, because the server disconnects its client whenever another one connects.

The claim of a card ends with the process that holds it.  When a recording will be over is noted in a file, for the next
daemon of the account after one that died during it; without that file nothing but the note is lost.
"""

from __future__ import annotations

import contextlib
import os
import socket
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Self

from drivers.claims import Claim, Claimed, holder_of
from drivers.errors import DeviceDenied


class CardLock:
    """Held until it is closed or the process ends; see `lock_card`."""

    def __init__(self, claim: Claim, note: int | None) -> None:
        self._claim = claim
        self._note = note

    def note_recording(self, end_s: float) -> None:
        """Note that the server sends samples until `end_s` (monotonic time of this computer), even if this process
        dies."""
        if self._note is not None:
            with contextlib.suppress(OSError):  # a full disk must cost no shot
                os.ftruncate(self._note, 0)
                os.pwrite(self._note, f"{end_s:.3f}".encode(), 0)

    def recording_until(self) -> float:
        """The end that the previous daemon has noted, -inf if it has noted none; it may be of an earlier boot."""
        try:
            return float("-inf") if self._note is None else float(os.pread(self._note, 40, 0))
        except (OSError, ValueError):
            return float("-inf")

    def close(self) -> None:
        """Release the card.  Idempotent."""
        if self._note is not None:
            os.close(self._note)
            self._note = None
        self._claim.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


def lock_card(host: str, port: int) -> CardLock:
    """Hold the card at this address, by whatever name, until what is returned is closed or the process ends.

    Raises DeviceDenied if another process of this computer holds it, whatever its account.
    """
    address = _address(host)
    name = f"io-card/{address[-60:]}:{port}"  # the end of a long host name tells hosts apart as well as the whole
    try:
        claim = Claim(name)
    except Claimed:
        holder = holder_of(name)
        who = "another process holds it" if holder is None else f"process {holder.pid} holds it"
        raise _denied(host, port, "another daemon on this computer uses the card", who) from None
    except OSError as error:
        raise _denied(host, port, "the card cannot be claimed", error.strerror or str(error)) from None
    return CardLock(claim, _open_note(note_path(address, port)))


def note_path(address: str, port: int) -> Path:
    """The note of a card: one for each account, because an account cannot write the files of another one."""
    name = f"{address}-{port}-{os.getuid()}".replace(os.sep, "_")
    return Path(tempfile.gettempdir()) / f"platform-daemon-io-card-{name}.note"


def _open_note(path: Path) -> int | None:
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    except OSError:
        return None


def _address(host: str) -> str:
    """The address of a host name; the name itself if it cannot be resolved, which connecting will report."""
    try:
        return socket.gethostbyname(host)
    except OSError:
        return host


def _denied(host: str, port: int, what: str, why: str) -> DeviceDenied:
    remedy = "stop it: a second connection would throw it out in the middle of a shot"
    return DeviceDenied(what, where=f"{host}:{port}", why=why, remedy=remedy)
