"""Lists come in pages: `?limit=&after=`; the header `Link` of an answer leads to the next one (RFC 8288)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar
from urllib.parse import quote, urlencode

from fastapi import Depends, Query, Request, Response

from drivers.errors import InputError
from platform_daemon.schemas import Schema

ItemT = TypeVar("ItemT")
DEFAULT_LIMIT, MOST = 200, 1000
MOST_BYTES = 4_000_000
"""Of a page of jobs: a job holds the fits of all its shots, so that a number of jobs says little of what they weigh."""
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
"""What a list declares beside its content."""


@dataclass(frozen=True)
class Page:
    """A stretch of a list: at most `limit` entries after the one called `after`, None: from the beginning."""

    limit: int
    after: str | None
    path: str
    headers: Any  # of the answer
    asked: str = ""  # the other keys of the query, as `key=value&`

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
        """The same of a mapping."""
        return {key: items[key] for key in self.of(tuple(items))}

    def goes_on_after(self, last: str) -> None:
        """Set the link to the next page."""
        self.headers["Link"] = f'<{self.path}?{self.asked}limit={self.limit}&after={quote(last, safe="")}>; rel="next"'

    def as_json(self, items: Iterable[tuple[str, Schema]]) -> Response:
        """The JSON array of the items on this page, by key; no longer than `MOST_BYTES`, but one item at least."""
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
        return Response(f"[{','.join(texts)}]", media_type="application/json", headers=dict(self.headers))


async def _page(request: Request, response: Response, limit: Limit = DEFAULT_LIMIT, after: After = None) -> Page:
    others = [(key, value) for key, value in request.query_params.multi_items() if key not in ("limit", "after")]
    asked = f"{urlencode(others)}&" if others else ""
    return Page(limit, after, request.url.path, response.headers, asked)


Paged = Annotated[Page, Depends(_page)]
