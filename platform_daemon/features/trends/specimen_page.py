"""What is known of a specimen, put together from index, catalogue and adopted models."""

from __future__ import annotations

from collections.abc import Iterable
from urllib.parse import quote

from drivers.errors import ConfigError
from drivers.specimen import Specimen
from platform_daemon.core.schemas.requests import SequencePreset
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.settings import load_sequence
from platform_daemon.core.web.context import Context
from platform_daemon.features.models.library import Library
from platform_daemon.features.models.schema import AdoptedModelSummary

from .index_keeper import TrendKeeper
from .schema import SpecimenPage, SpecimenResonator


def specimen_page(specimen: str, context: Context) -> SpecimenPage:
    """The page.  Raises UnknownSpecimen, StorageError."""
    from .indexed import indexed_specimen

    specimen = same_name(specimen)
    found = indexed_specimen(context.folders.recordings, specimen)
    trend = context.part(TrendKeeper).trend(specimen)
    here = f"/specimens/{quote(specimen, safe='')}"
    parts = {"trend": "/trend", "picture": "/trend/picture", "table": "/trend/table"}
    return SpecimenPage(
        specimen=specimen,
        recordings=len(found.identifiers),
        shots=found.shots,
        first=found.first,
        last=found.last,
        resonators=tuple(_resonator(name, count, context) for name, count in found.resonators.items()),
        calibrations=dict(found.calibrations),
        models=_models(found.identifiers, context),
        tags=tuple(found.tags),
        changes=tuple(each for each in trend.changes if each.stands),
        links={
            "self": here,
            **{name: here + part for name, part in parts.items()},
            "recordings": f"/recordings?specimen={quote(specimen, safe='')}",
        },
    )


def _resonator(name: str, recordings: int, context: Context) -> SpecimenResonator:
    """As the catalogue has it: of those of that name the one that was added last."""
    known = [(key, each) for key, each in context.catalogue.resonators.all().items() if isinstance(each, Specimen)]
    named = [(key, each) for key, each in known if each.name == name and "@" not in key]
    if not named:
        return SpecimenResonator(
            name=name, key=None, recordings=recordings, variant=None, max_field_t=None, operating_field_t=None,
            sequence=None,
        )  # fmt: skip
    key, found = named[-1]
    modes = found.side_modes
    return SpecimenResonator(
        name=name,
        key=key,
        recordings=recordings,
        variant=found.variant,
        max_field_t=None if modes is None else modes.max_field_t,
        operating_field_t=None if modes is None else modes.operating_field_t,
        sequence=_sequence(key, found, context),
    )


def _sequence(key: str, found: Specimen, context: Context) -> SequencePreset | None:
    """None: the tuned preset is damaged, which the list of resonators says."""
    preset = SequencePreset.model_validate(load_sequence(found.variant).model_dump())
    try:
        tuned = context.catalogue.tuned.preset_of(key, found)
    except ConfigError:
        return None
    return preset.model_copy(update=tuned.keys.changes())


def _models(recordings: Iterable[str], context: Context) -> tuple[AdoptedModelSummary, ...]:
    """Whose record names one of them."""
    known, _ = Library(context.folders.models).all()
    texts = {model.label: model.record().model_dump_json() for model in known}
    return tuple(model.summary() for model in known if any(each in texts[model.label] for each in recordings))
