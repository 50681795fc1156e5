"""Which recordings a list is requested."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeVar

from fastapi import Query

from drivers.errors import InputError
from platform_daemon.core.recordings.indexed import Wanted
from platform_daemon.core.web.context import Context

ValueT = TypeVar("ValueT")


@dataclass(frozen=True)
class RecordingQuery:
    """What is looked for."""

    specimen: Annotated[str | None, Query(description="name of the sample, or of the resonator if none was given")] = (
        None
    )
    sample: Annotated[str | None, Query(description="the same: the name of the sample")] = None
    resonator: Annotated[str | None, Query(description="name of the resonator, as its file says")] = None
    operator: Annotated[str | None, Query(min_length=1, description="part of the operator's name")] = None
    since: Annotated[str | None, Query(max_length=40, description="begun from then on, ISO 8601")] = None
    until: Annotated[str | None, Query(max_length=40, description="begun until then; a date: until its end")] = None
    refused: Annotated[bool | None, Query(description="true: with a refused shot; false: without")] = None
    verdict: Annotated[
        Literal["good", "refused"] | None, Query(description="refused: with a refused shot; good: without")
    ] = None
    tag: Annotated[str | None, Query(min_length=1, max_length=64, description="a word of the comment after #")] = None

    def files(self, context: Context) -> set[str] | None:
        """Names of the files; None: all.  Raises InputError, StorageError."""
        from platform_daemon.features.trends.index_keeper import TrendKeeper
        from platform_daemon.features.trends.indexed import find_recordings

        specimen = _one_of("specimen", self.specimen, "sample", self.sample)
        said = None if self.verdict is None else self.verdict == "refused"
        refused = _one_of("refused", self.refused, "verdict", said)
        wanted = Wanted(specimen, self.operator, self.since, self.until, refused, self.tag, self.resonator)
        if wanted == Wanted():
            return None
        context.part(TrendKeeper).catch_up()
        return set(find_recordings(context.folders.recordings, wanted))


def _one_of(name: str, value: ValueT | None, other: str, also: ValueT | None) -> ValueT | None:
    """Two keys for one thing.  Raises InputError where they say different things."""
    if value is not None and also is not None and value != also:
        raise InputError(f"{name} and {other} exclude each other", where=other, remedy="give one of them")
    return also if value is None else value
