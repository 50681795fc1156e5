"""A key of the query that nobody knows is refused: one that is misspelt would ask for everything."""

from __future__ import annotations

import difflib
from collections.abc import Collection

from fastapi import params
from fastapi.dependencies.utils import get_flat_params
from fastapi.routing import APIRoute
from starlette.datastructures import QueryParams

from drivers.errors import InputError


def query_keys(route: APIRoute) -> frozenset[str]:
    """Those that a route takes, of what it depends on, too."""
    return frozenset(f.alias for f in get_flat_params(route.dependant) if isinstance(f.field_info, params.Query))


def check_query(query: QueryParams, known: Collection[str]) -> None:
    """Raises InputError for the first key that is not known."""
    unknown = next((key for key in query if key not in known), None)
    if unknown is None:
        return
    near = difflib.get_close_matches(unknown, known, 1)
    there = f"this path takes {', '.join(sorted(known))}" if known else "this path takes none"
    remedy = f"say {near[0]}" if near else "leave it out; /docs shows what each path takes"
    raise InputError(f"no key of the query is called {unknown[:100]!r}", where="query", why=there, remedy=remedy)
