"""The sequence of a request, and where each of its values comes from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivers.errors import InputError
from drivers.specimen import Specimen
from drivers.validation import validated
from platform_daemon.core.hardware.catalogue import Catalogue, Damping, Shelf
from platform_daemon.core.schemas.requests import SHIPPED_PRESET, TUNED_PRESET, AcquisitionRequest
from platform_daemon.core.schemas.value_sources import GIVEN, SHIPPED, Origin, Origins, ValueSource
from platform_daemon.core.settings import load_sequence, refuse_foreign_preset, shipped
from sequences.request import SequenceRequest

_ALWAYS = ("f_tx_hz", "tx_periods", "field_t", "axis", "rx_s", "pause_s")
"""Keys whose source is said always; that of another one, where it is not that of the shipped preset."""
_COUNTS = ("repetitions", "blank_shots")


@dataclass(frozen=True)
class SourcedSequence:
    """A sequence, and where its values come from.

    Attributes:
        stale_preset: why a tuned preset is not used; None: it is, or there is none.
        damping: what the tune of the preset in use has found; None: no tuned preset is used.
    """

    sequence: SequenceRequest
    sources: tuple[ValueSource, ...]
    stale_preset: str | None
    damping: Damping | None


def sourced_sequence(
    request: AcquisitionRequest,
    specimen: Specimen,
    catalogue: Catalogue,
    origins: Origins,
    *,
    use_tuned: bool = True,
) -> SourcedSequence:
    """The preset that ships, with the keys of a tuned one, of a named one, and of the request, in this order.

    origins: of keys of the request that somebody else than its author has chosen.  Raises ConfigError for a key that
    cannot be, InputError for a preset that does not exist.
    """
    preset = request.preset
    keys: dict[str, Any] = load_sequence(specimen.variant).model_dump()
    found = dict.fromkeys(keys, Origin("shipped", path=f"preset {specimen.variant}"))
    stale, damping = None, None
    if use_tuned and preset != SHIPPED_PRESET:
        tuned = catalogue.tuned.preset_of(request.resonator, specimen)
        stale, damping = tuned.stale, tuned.damping
        if preset == TUNED_PRESET and not tuned.keys.changes():
            raise InputError(
                f"there is no tuned preset of {request.resonator}",
                where="preset",
                why=stale or "",
                remedy="tune the resonator first, or use the preset that ships: shipped",
            )
        keys |= tuned.keys.changes()
        found |= dict.fromkeys(tuned.keys.changes(), Origin("tuned", tuned.job, tuned.date, tuned.label))
    if preset not in (None, SHIPPED_PRESET, TUNED_PRESET):
        named, path = _named(preset, specimen, catalogue)
        keys |= named
        found |= dict.fromkeys(named, Origin("file", path=path))
    given = request.sequence.changes()
    keys |= given | {"repetitions": request.shots, "blank_shots": request.blank_shots}
    found |= dict.fromkeys(given, GIVEN) | dict(origins)
    sequence = validated(SequenceRequest, keys, "sequence")
    return SourcedSequence(sequence, tuple(_sources(sequence, found)), stale, damping)


def _sources(sequence: SequenceRequest, origins: Origins) -> list[ValueSource]:
    found = []
    for key, value in sequence.model_dump(exclude={*_COUNTS}).items():
        origin = origins.get(key, SHIPPED)
        if key in _ALWAYS or origin.source != "shipped":
            shown = ", ".join(f"{k} = {v:g}" for k, v in value.items()) if isinstance(value, dict) else value
            found.append(origin.of(key, shown))
    return found


def specimen_sources(resonator: str, specimen: Specimen, shelf: Shelf[Specimen]) -> list[ValueSource]:
    """Which declaration of the resonator is used, and the limit that a ramp has kept with it."""
    path = shelf.files().get(resonator)
    ships = path is not None and path in shipped(shelf.kind).values()
    name = resonator if path is None else path.name
    declared = SHIPPED if ships else Origin("file", path=name)
    limit = specimen.side_modes
    kept = [] if limit is None else [Origin("ramp", limit.job, limit.found, name).of("max_field_t", limit.max_field_t)]
    return [declared.of("resonator", resonator), *kept]


def _named(preset: str | None, specimen: Specimen, catalogue: Catalogue) -> tuple[dict[str, Any], str]:
    """The keys of a sequence of the catalogue, or of the file of this path, and what to call it.

    Raises InputError for the preset that ships for the other bearing, ConfigError for what does not exist.
    """
    assert preset is not None
    path = catalogue.sequences.files().get(preset)
    remedy = "leave `preset` out, or give the keys that differ as `sequence`"
    refuse_foreign_preset(path or Path(preset), specimen, "preset", remedy)
    return catalogue.sequences.load(preset)[0].changes(), preset if path is None else path.name
