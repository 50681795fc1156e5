"""Requests to one daemon: version, token, repetition, pages of lists."""

from __future__ import annotations

import ssl
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import httpx2
from pydantic import BaseModel

from drivers.errors import InputError
from platform_daemon.client import answers
from platform_daemon.client.errors import ConnectionFailed
from platform_daemon.client.operations import Operation, operations

T = TypeVar("T")


class Transport:
    """One daemon.  Every method may raise ClientError.

    url: its address; token: None, if it needs none; ca_file: certificate that its certificate is checked against, None:
    those of the system.
    """

    def __init__(self, url: str, token: str | None = None, ca_file: str | Path | None = None) -> None:
        self.url = answers.checked_url(url)
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        verify = True if ca_file is None else ssl.create_default_context(cafile=str(ca_file))
        self._http = httpx2.Client(base_url=self.url, headers=headers, timeout=answers.TIMEOUT, verify=verify)
        self._operations = operations()
        self._checked = False

    def close(self) -> None:
        """Close the connections.  Idempotent."""
        self._http.close()

    def get(self, model: type[T], operation: str, query: Mapping[str, Any] | None = None, **path: Any) -> T:
        """The answer of an operation without a body."""
        return answers.value_of(self.send(operation, query=query, **path), model)

    def post(
        self,
        model: type[T],
        operation: str,
        body: BaseModel | None = None,
        query: Mapping[str, Any] | None = None,
        *,
        key: str | None = None,
        **path: Any,
    ) -> T:
        """The answer of an operation with a body; None: `{}`; key: its idempotency key, None: it has none."""
        content = "{}" if body is None else body.model_dump_json()
        return answers.value_of(self.send(operation, content=content, query=query, key=key, **path), model)

    def send(
        self,
        operation: str,
        *,
        content: str | None = None,
        query: Mapping[str, Any] | None = None,
        key: str | None = None,
        **path: Any,
    ) -> httpx2.Response:
        """The answer to a request; one that cannot do anything twice is repeated while the daemon does not answer.

        key: idempotency key, with which a POST is such a request.
        """
        self._check_open()
        if operation != "stop":  # which is never held up
            self.check_daemon()
        found = self._operations[operation]
        request = self._request(found, answers.path_of(found, path), content, query, key)
        return self._answer(request, found, key)

    def items(self, model: type[T], operation: str, query: Mapping[str, Any] | None = None, **path: Any) -> Iterator[T]:
        """The entries of a list, page by page."""
        self.check_daemon()
        found = self._operations[operation]
        request = self._request(found, answers.path_of(found, path), None, query, None)
        while True:
            page = answers.page_of(self._answer(request, found, None), model)
            yield from page.items
            if page.next is None:
                return
            request = self._http.build_request("GET", self._same_origin(page.next))

    def check_daemon(self) -> None:
        """Once: is there a daemon of this version?  Raises ConnectionFailed, NotADaemon, VersionMismatch."""
        self._check_open()
        if self._checked:
            return
        health = self._operations["get_health"]
        try:
            response = self._http.get(health.path)
        except httpx2.TransportError as error:
            raise answers.connection_failed(error, self.url, health, key=None) from None
        answers.check_version(response)
        self._checked = True

    def _check_open(self) -> None:
        """Raises InputError."""
        if self._http.is_closed:
            remedy = "use it, and its jobs and recordings, inside of `with Client() as lab:`, or open another one"
            raise InputError("the client is closed", where="Client", remedy=remedy)

    @contextmanager
    def stream(
        self, operation: str, headers: Mapping[str, str], query: Mapping[str, Any] | None = None, **path: Any
    ) -> Iterator[httpx2.Response]:
        """An answer whose body is read bit by bit; a lost connection raises httpx2.TransportError."""
        self.check_daemon()
        found = self._operations[operation]
        place = self._place(answers.path_of(found, path))
        with self._http.stream(found.method, place, params=_plain(query), headers=dict(headers)) as response:
            if not response.is_success:
                response.read()
                answers.check(response)
            yield response

    def connection_failed(self, error: Exception, operation: str) -> ConnectionFailed:
        """The exception for an operation whose answer did not come."""
        return answers.connection_failed(error, self.url, self._operations[operation], key=None)

    def _request(
        self, operation: Operation, path: str, content: str | None, query: Mapping[str, Any] | None, key: str | None
    ) -> httpx2.Request:
        headers = {} if content is None else {"Content-Type": "application/json"}
        headers |= {} if key is None else {"Idempotency-Key": key}
        place = self._place(path)
        return self._http.build_request(operation.method, place, params=_plain(query), content=content, headers=headers)

    def _place(self, path: str) -> str:
        """Below the path of the daemon's address, as behind a proxy."""
        return path.removeprefix("/") if self.url.path != "/" else path

    def _same_origin(self, path: str) -> httpx2.URL:
        """A path of an answer at the daemon's own host, so that the token is sent nowhere else."""
        root = self.url.path.removesuffix("/")
        inside = path if not root or path.startswith(f"{root}/") else f"{root}{path}"
        return self.url.copy_with(raw_path=inside.encode())

    def _answer(self, request: httpx2.Request, operation: Operation, key: str | None) -> httpx2.Response:
        until_s, wait_s = time.monotonic() + answers.PATIENCE_S, answers.FIRST_WAIT_S
        while True:
            repeats = (operation.repeatable or key is not None) and time.monotonic() < until_s
            pause_s = wait_s
            try:
                response = self._http.send(request)
            except httpx2.TransportError as error:
                if not repeats:
                    raise answers.connection_failed(error, self.url, operation, key=key) from None
            else:
                if not (repeats and answers.will_pass(response)):
                    answers.check(response)
                    return response
                pause_s = answers.wait_of(response, wait_s)
            time.sleep(pause_s)
            wait_s = min(2 * wait_s, answers.LONGEST_WAIT_S)


def _plain(query: Mapping[str, Any] | None) -> dict[str, Any]:
    """Without the keys that were not given."""
    return {name: value for name, value in (query or {}).items() if value is not None and value != ()}
