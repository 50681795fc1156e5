"""The tokens of a data folder: one file, readable by its owner only, which holds hashes and never a token."""

from __future__ import annotations

import fcntl
import hmac
import json
import os
import re
import secrets
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO

from drivers.errors import ConfigError, InputError
from platform_daemon.core.schemas.access import TOKEN_NAME, TokenRecord, TokenRecords
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.roles import Role

from .accounts import give_to_owner_of_parent
from .durable import write_file
from .errors import StorageUnusable

_READ = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC  # no link, and no pipe that is waited for
RESERVED = ("local",)
"""Names that the audit log gives to callers without a token."""
TOKENS = "tokens.json"
"""Name of the file in a data folder."""


class TokenFile:
    """The tokens in the file at `path`.

    The file is read again when it has changed, so a token that is revoked is refused at once by a server that runs.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        # As of which state of the file; one value, as two threads may read at once.
        self._known: tuple[tuple[int, ...] | None, tuple[TokenRecord, ...]] = (None, ())

    @property
    def exists(self) -> bool:
        """Whether a token was ever made here; False also for a folder that may not be read."""
        try:
            return self._known[0] is not None or self.path.exists()
        except OSError:
            return False

    def records(self) -> tuple[TokenRecord, ...]:
        """All tokens, oldest first; none if there is no file.

        Raises ConfigError if the file cannot be read, is damaged, can be written by other users, or was there before
        and is missing now, as when its disk was taken away.
        """
        try:
            with _opened(self.path) as file:  # what is looked at is what is read
                state = os.fstat(file.fileno())
                seen = (state.st_ino, state.st_mtime_ns, state.st_size, state.st_mode, state.st_uid)
                known, records = self._known
                if seen == known:
                    return records
                text, ours = file.read(), (0, os.geteuid(), self.path.parent.stat().st_uid)
        except (FileNotFoundError, NotADirectoryError):  # the latter: who opens the data folder says what is wrong
            if self._known[0] is None:
                return ()
            remedy = "look whether the disk of the data folder is there; put back a copy, or create the tokens again"
            raise ConfigError("the tokens are gone", where=str(self.path), remedy=remedy) from None
        except OSError as error:
            remedy = "make it a file, no link, that the user of the daemon can read, with mode 0600"
            raise ConfigError(
                "the tokens cannot be read", where=str(self.path), why=str(error), remedy=remedy
            ) from None
        if state.st_uid not in ours:  # an account that may write the folder can replace the file
            what, remedy = (
                "another account owns this file of tokens",
                "look at who is in it, and who may write the folder",
            )
            raise ConfigError(what, where=str(self.path), why=f"it belongs to uid {state.st_uid}", remedy=remedy)
        if state.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            what, remedy = (
                "other users could give themselves a token",
                f"chmod 600 {self.path}, and look at who is in it",
            )
            raise ConfigError(what, where=str(self.path), why="they may write the file", remedy=remedy)
        try:
            found = TokenRecords.model_validate(json.loads(text)).tokens
        except (ValueError, RecursionError) as error:
            why = str(error).splitlines()[0]
            remedy = "put back a copy, or delete it and create the tokens again"
            raise ConfigError("is no file of tokens", where=str(self.path), why=why, remedy=remedy) from None
        self._known = (seen, found)
        return found

    def remember(self, before: Path) -> None:
        """Take the tokens of the file `before` for those that were read last."""
        with suppress(OSError, ValueError, RecursionError):
            self._known = (), TokenRecords.model_validate_json(before.read_bytes()).tokens

    def holder(self, token: str) -> TokenRecord | None:
        """The record of a token, or None.  Raises ConfigError as `records` does."""
        return _found(token, self.records())

    def last_holder(self, token: str) -> TokenRecord | None:
        """The record of a token when the file could last be read, or None."""
        return _found(token, self._known[1])

    def add(self, name: str, role: Role, expires: datetime | None = None) -> str:
        """Make a token and return it; the file keeps only its hash.

        Raises InputError for a name that is taken or not allowed, or an `expires` in the past; StorageError;
        StorageUnusable if the folder cannot be made.
        """
        if not re.fullmatch(TOKEN_NAME, name) or name in RESERVED:
            remedy = "letters, digits, _ . and -, at most 60, not 'local'"
            raise InputError(f"no token can be called {name!r}", where="NAME", remedy=remedy)
        if expires is not None and expires <= datetime.now(UTC):
            raise InputError("it would have expired already", where="--expires", remedy="give a moment to come")
        # 256 random bits.  They cannot be guessed from their SHA-256, however fast that is: a slow hash with salt is
        # for what people choose themselves, and would cost every request of a poller tens of milliseconds.
        token = f"pd_{secrets.token_urlsafe(32)}"
        made = datetime.now(UTC).isoformat(timespec="seconds")
        until = None if expires is None else expires.isoformat(timespec="seconds")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            why, remedy = error.strerror or str(error), "give the data folder of the server with --data"
            what = "the data folder cannot be used"
            raise StorageUnusable(what, where=str(self.path.parent), why=why, remedy=remedy) from None
        with self._alone():
            before = self.records()
            if any(record.name == name for record in before):
                remedy = f"choose another name, or `platform-daemon token revoke {name}` first"
                raise InputError(f"there is a token called {name!r}", where="NAME", remedy=remedy)
            record = TokenRecord(name=name, role=role, sha256=_digest(token), created=made, expires=until)
            self._write((*before, record))
        return token

    def revoke(self, name: str) -> TokenRecord:
        """Revoke a token and return its record.  The file stays, even empty, so that a token is still demanded.

        Raises InputError if there is none of that name; StorageError.
        """
        if not self.exists:
            raise _unknown(name)
        with self._alone():
            before = self.records()
            revoked = next((record for record in before if record.name == name), None)
            if revoked is None:
                raise _unknown(name)
            self._write(tuple(record for record in before if record.name != name))
        return revoked

    def _write(self, records: tuple[TokenRecord, ...]) -> None:
        text = to_json(TokenRecords(tokens=records), indent=2) + "\n"
        write_file(self.path, text.encode(), mode=0o600)

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Keep other commands from changing the file meanwhile."""
        path = self.path.with_name(f".{self.path.name}.lock")
        with path.open("w") as lock:
            give_to_owner_of_parent(path)
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield


def tokens_in(folder: Path) -> TokenFile:
    """The tokens of a data folder, which a daemon may have open."""
    return TokenFile(folder / TOKENS)


def _opened(path: Path) -> BinaryIO:
    """Raises OSError, also for a path that is no regular file."""
    number = os.open(path, _READ)
    if stat.S_ISREG(os.fstat(number).st_mode):
        return open(number, "rb")
    os.close(number)
    raise OSError("it is no file")


def has_expired(record: TokenRecord) -> bool:
    """Whether a token has expired; one whose time cannot be parsed has."""
    if record.expires is None:
        return False
    try:
        return datetime.fromisoformat(record.expires) <= datetime.now(UTC)
    except (ValueError, TypeError):
        return True


def _found(token: str, records: Iterable[TokenRecord]) -> TokenRecord | None:
    digest, found = _digest(token), None
    for record in records:
        # In constant time, and to the end of the list: how long it takes tells nothing of what is in the file.
        if hmac.compare_digest(record.sha256, digest):
            found = record
    return found


def _unknown(name: str) -> InputError:
    remedy = "`platform-daemon token list` tells their names; --data is the folder of the server"
    return InputError(f"no token is called {name!r}", where="NAME", remedy=remedy)


def _digest(token: str) -> str:
    return sha256(token.encode("utf-8", "surrogateescape")).hexdigest()
