"""HTTP as it is read here: what could mean two things to two readers is refused, and how that is said."""

from __future__ import annotations

import json
from http import HTTPStatus
from typing import Any

import h11


class StrictConnection(h11.Connection):
    """h11 takes Transfer-Encoding where Content-Length is there, too (RFC 9112, 6.3): a proxy before us may take the
    other, and see one request where we see two.  HTTP/1.0 knows no Transfer-Encoding (6.1).

    has_two_lengths: that was why the last event was refused.
    """

    has_two_lengths = False

    def next_event(self) -> Any:
        """See h11.  Raises RemoteProtocolError."""
        event = super().next_event()
        if isinstance(event, h11.Request):
            names = [name for name, _ in event.headers]
            if b"transfer-encoding" in names and (b"content-length" in names or event.http_version != b"1.1"):
                self.has_two_lengths = True
                raise h11.RemoteProtocolError("two lengths")
        return event


def refusal(status: int, title: str, what: str, remedy: str) -> bytes:
    """An answer of a connection that no application has seen, as it goes over the wire; the connection ends."""
    body = {"type": "about:blank", "title": title, "status": status, "detail": f"{what}. Remedy: {remedy}."}
    again = "retry-after: 1\r\n" if status == HTTPStatus.SERVICE_UNAVAILABLE else ""
    head = f"HTTP/1.1 {status} {HTTPStatus(status).phrase}\r\ncontent-type: application/problem+json\r\n{again}"
    return f"{head}connection: close\r\n\r\n{json.dumps({**body, 'remedy': remedy})}".encode()
