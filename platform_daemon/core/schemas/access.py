"""Who may do what: roles, tokens as their file keeps them, lines of the audit log, an answer without content."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from .base import ListPage, Request, Schema, example
from .roles import Role

TOKEN_NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,59}$"


class TokenRecord(Schema):
    """A token as its file keeps it: everything but the token itself."""

    name: Annotated[str, Field(pattern=TOKEN_NAME)]
    """Name of its holder, as in the audit log."""
    role: Role
    """What the holder may do."""
    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    """SHA-256 of the token, hexadecimal."""
    created: str
    """When it was made, ISO 8601."""
    expires: str | None
    """From when on it is not valid any more, ISO 8601 with offset; null: never."""


class TokenRecords(Schema):
    """The file of the tokens."""

    tokens: tuple[TokenRecord, ...]
    """Oldest first."""


class CallerInfo(Schema):
    """Who sends a request, and what the sender may do."""

    model_config = ConfigDict(json_schema_extra=example("caller_info"))

    name: str
    """Name of the token; "local": none is needed; empty: the request is without a valid token."""
    role: Role | None
    """What the caller may do; null: nothing that needs a token."""
    refused: str | None
    """Why the token is not accepted, or that one is needed; null: it is accepted."""


class AuditEntry(Schema):
    """One line of the audit log: something that changes what the platform does, or who may change it."""

    when: str
    """ISO 8601, UTC."""
    who: str
    """Name of the token; "local": none was demanded; of a change of tokens the user of the computer."""
    address: str
    """From where: the client's address, or "command line"."""
    what: str
    """Name of the operation, as stop or adopt_calibration."""
    path: str
    """Path of the request with its query; empty for commands."""
    request: str
    """What was requested: the JSON of the request, cut after 2000 characters."""
    status: int
    """HTTP status of the answer; 0: a command that was done."""
    outcome: str
    """done, or why it was not."""


class ChangeListing(ListPage[AuditEntry]):
    """Lines of the audit log, newest first."""

    model_config = ConfigDict(json_schema_extra=example("audit_entry", listed=True))


class Confirmation(Request):
    """What a request holds that needs no values: `{}`, or nothing.

    It is sent as JSON all the same, because a page that a browser shows from elsewhere cannot do that unasked.
    """

    model_config = ConfigDict(json_schema_extra={"examples": [{}]})
