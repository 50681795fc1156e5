"""What can be measured and how: resonators and sequences that ship, those of the lab, and those added here."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Body, Query, Response
from fastapi import Path as PathParameter
from pydantic import BaseModel

from drivers.errors import ConfigError
from drivers.specimen import Specimen
from platform_daemon.core.hardware.catalogue import Shelf
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.recordings.index import Broken
from platform_daemon.core.schemas.platform import (
    CatalogueEntry,
    ResonatorInfo,
    ResonatorListing,
    SequenceInfo,
    SequenceListing,
)
from platform_daemon.core.schemas.problems import UnreadableFile
from platform_daemon.core.schemas.requests import SequencePatch, SequencePreset
from platform_daemon.core.settings import load_sequence, load_specimen
from platform_daemon.core.web.context import Shared
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, Paged
from platform_daemon.core.web.problems import problems, unreadable

router = APIRouter(tags=["catalogue"], route_class=GuardedRoute)
ContentT = TypeVar("ContentT", bound=BaseModel)
NewName = Annotated[
    str,
    Query(
        pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,59}$",
        description="its name; one that was added before gets a new version",
        examples=["t07"],
    ),
]
Name = Annotated[str, PathParameter(description="NAME, or NAME@VERSION of what was added", examples=["thread"])]
GENTLE = {"field_t": 4.0e-4, "rx_s": 2.0}
THREAD = load_specimen("thread")[0]
NewResonator = Annotated[Specimen, Body(examples=[THREAD.model_dump(exclude_none=True)])]
NewSequence = Annotated[SequencePatch, Body(examples=[GENTLE])]


def _example(content: dict[str, Any]) -> dict[int | str, dict[str, Any]]:
    """An answer of a route whose schema has no example of its own."""
    return {200: {"content": {"application/json": {"example": content}}}}


@router.get("/resonators", summary="Resonators that can be measured", responses={**NEXT, **problems(422)})
def list_resonators(context: Shared, page: Paged) -> ResonatorListing:
    """Resonators by the name to use in an acquisition, with variant and preset, a tuned one where there is one.

    What was added is there by NAME, its newest version, and by NAME@VERSION; what cannot be read with the reason.
    """
    presets = {v: SequencePreset.model_validate(load_sequence(v).model_dump()) for v in ("thread", "jewel")}

    def shown(name: str, found: Specimen) -> ResonatorInfo | UnreadableFile:
        try:
            tuned = context.catalogue.tuned.preset_of(name, found)
        except ConfigError as error:
            return unreadable(Broken(name, Path(error.where), error))
        sequence = presets[found.variant].model_copy(update=tuned.keys.changes())
        return ResonatorInfo(id=name, name=found.name, variant=found.variant, sequence=sequence)

    here = page.part_of(context.catalogue.resonators.all())
    entries = [unreadable(each) if isinstance(each, Broken) else shown(name, each) for name, each in here.items()]
    return ResonatorListing(
        items=tuple(each for each in entries if isinstance(each, ResonatorInfo)),
        broken=tuple(each for each in entries if isinstance(each, UnreadableFile)),
        next=page.next,
    )


@router.post("/resonators", summary="Add a resonator", status_code=201, responses=problems(415, 422, 507))
def add_resonator(name: NewName, body: NewResonator, response: Response, context: Shared) -> CatalogueEntry:
    """Keep a resonator file, with the same keys in JSON, as the next version of its name."""
    return _added(context.catalogue.resonators, name, body, response)


@router.get(
    "/resonators/{name}",
    summary="A resonator",
    responses={**_example(THREAD.model_dump(mode="json")), **problems(404, 422)},
)
def get_resonator(name: Name, context: Shared) -> Specimen:
    """What its file holds; keys that it leaves out are null."""
    return _found(context.catalogue.resonators, name)


@router.get("/sequences", summary="Sequences that have a name", responses={**NEXT, **problems(422)})
def list_sequences(context: Shared, page: Paged) -> SequenceListing:
    """Sequences by the name to use as `preset` of an acquisition, with the keys that they set; what cannot be read
    with the reason."""
    here = page.part_of(context.catalogue.sequences.all())
    return SequenceListing(
        items=tuple(SequenceInfo(id=n, sequence=each) for n, each in here.items() if not isinstance(each, Broken)),
        broken=tuple(unreadable(each) for each in here.values() if isinstance(each, Broken)),
        next=page.next,
    )


@router.post("/sequences", summary="Add a sequence", status_code=201, responses=problems(415, 422, 507))
def add_sequence(name: NewName, body: NewSequence, response: Response, context: Shared) -> CatalogueEntry:
    """Keep the keys that differ from a resonator's preset as the next version of a name."""
    return _added(context.catalogue.sequences, name, body, response)


@router.get("/sequences/{name}", summary="A sequence", responses={**_example(GENTLE), **problems(404, 422)})
def get_sequence(name: Name, context: Shared) -> SequencePatch:
    """The keys that it sets."""
    return _found(context.catalogue.sequences, name)


def _added(shelf: Shelf[ContentT], name: str, content: ContentT, response: Response) -> CatalogueEntry:
    version = shelf.add(name, content)
    response.headers["Location"] = f"/{shelf.kind}/{version.path.stem}"
    return CatalogueEntry(name=name, version=version.number, label=version.path.stem)


def _found(shelf: Shelf[ContentT], name: str) -> ContentT:
    if name not in shelf.files():
        what, remedy = f"no {shelf.kind[:-1]} is called {name!r}", f"GET /{shelf.kind} lists all"
        raise UnknownId(what, where=name, remedy=remedy)
    return shelf.named(name)
