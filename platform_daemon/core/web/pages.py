"""Pages of lists: `?limit=&after=`; `next` and the header `Link` (RFC 8288) of an answer lead to the next page."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar
from urllib.parse import quote, urlencode

from fastapi import Depends, Query, Request, Response

from drivers.errors import InputError
from platform_daemon.core.schemas.base import Schema

ItemT = TypeVar("ItemT")
DEFAULT_LIMIT, MOST = 200, 1000
MOST_BYTES = 4_000_000
"""Longest page of jobs: a job holds the fits of all its shots, so that the number of jobs does not bound its length."""
Limit = Annotated[int, Query(ge=1, le=MOST, description="at most so many entries; a page may hold fewer")]
After = Annotated[
    str | None,
    Query(min_length=1, max_length=300, description="those after this one, as the link to the next page says"),
]
NEXT: dict[int | str, dict[str, Any]] = {
    200: {
        "headers": {
            "Link": {
                "description": '`<PATH?limit=&after=>; rel="next"`: the page after this one; missing on the last one.',
                "schema": {"type": "string"},
            }
        }
    }
}
"""What the route of a list declares in addition to its content."""


@dataclass
class Page:
    """A page of a list: at most `limit` entries after the one with the key `after`, None: from the beginning.

    next: path of the page after this one, None: not known to be there.
    """

    limit: int
    after: str | None
    path: str
    headers: Any  # of the answer
    filters: str = ""  # the other keys of the query, as `key=value&`
    next: str | None = None

    def of(self, keys: Sequence[str]) -> Sequence[str]:
        """The keys on this page; the link to the next one is set.  Raises InputError for an `after` that is no key."""
        first = 0
        if self.after is not None:
            if self.after not in keys:
                remedy = "begin with the first page, and follow the links"
                raise InputError(f"nothing here is called {self.after!r}", where="after", remedy=remedy)
            first = keys.index(self.after) + 1
        found = keys[first : first + self.limit]
        if first + self.limit < len(keys):
            self.goes_on_after(found[-1])
        return found

    def part_of(self, items: Mapping[str, ItemT]) -> dict[str, ItemT]:
        """The entries of a mapping on this page."""
        return {key: items[key] for key in self.of(tuple(items))}

    def goes_on_after(self, last: str) -> None:
        """Set the link to the next page."""
        query = f"{self.filters}limit={self.limit}&after={quote(last, safe='')}"
        self.next = f"{self.path}?{query}"
        self.headers["Link"] = f'<{self.next}>; rel="next"'

    def as_json(self, items: Iterable[tuple[str, Schema]]) -> Response:
        """The ListPage of the items on this page, by key; no longer than `MOST_BYTES`, but one item at least."""
        texts: list[str] = []
        size, last = 0, ""
        for key, item in items:
            text = item.model_dump_json()
            size += len(text)
            if texts and size > MOST_BYTES:
                self.goes_on_after(last)
                break
            texts.append(text)
            last = key
        text = f'{{"items":[{",".join(texts)}],"next":{json.dumps(self.next)}}}'
        return Response(text, media_type="application/json", headers=dict(self.headers))


async def _page(request: Request, response: Response, limit: Limit = DEFAULT_LIMIT, after: After = None) -> Page:
    return requested_page(request, response, limit, after)


def requested_page(request: Request, response: Response, limit: int, after: str | None) -> Page:
    """The page that a request names; its links keep the other keys of the query."""
    others = [(key, value) for key, value in request.query_params.multi_items() if key not in ("limit", "after")]
    filters = f"{urlencode(others)}&" if others else ""
    return Page(limit, after, request.url.path, response.headers, filters)


Paged = Annotated[Page, Depends(_page)]
