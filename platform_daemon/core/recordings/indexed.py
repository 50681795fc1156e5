"""Rows of the index of the recordings, and the filter of a query."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from platform_daemon.core.schemas.base import ClockKind

from .index import Entry


@dataclass(frozen=True)
class IndexedShot:
    """A shot with a good fit.

    frame: from 0; at: ISO 8601; temperature_c: of the platform, None: not measured; field_t: peak of the field that it
    was excited with, None: not said; values: estimates and figures of the fit, by name with unit.
    """

    frame: int
    at: str
    temperature_c: float | None
    field_t: float | None
    values: Mapping[str, float]


@dataclass(frozen=True)
class IndexedPoint:
    """The mean of shots of one recording that were made within some minutes.

    at: ISO 8601, of the first; shots: how many; temperature_c: mean, None: not measured; field_t: as of a shot;
    values: means, by name with unit.
    """

    at: str
    shots: int
    temperature_c: float | None
    field_t: float | None
    values: Mapping[str, float]


@dataclass(frozen=True)
class IndexedRecording:
    """What the index holds of a recording.

    begun: ISO 8601; specimen: name of the sample; frames, good: all of them, and those that may be used; calibration:
    name of the receive calibration; fit: name of the on-line fits that the shots are from, None: it has none;
    resonator: its name; tags: words of the comment that begin with #, without it, in small letters; points: of its
    trend; step: of a procedure the one that the points are of, in words, "": it is of no procedure; clock: that its
    times go by, None: the file does not say; listed: what a list says of it, None: where it comes from the index.
    """

    identifier: str
    begun: str
    specimen: str
    operator: str
    frames: int
    good: int
    calibration: str | None
    fit: str | None
    resonator: str = ""
    step: str = ""
    clock: ClockKind | None = None
    tags: frozenset[str] = frozenset()
    points: Sequence[IndexedPoint] = field(default_factory=tuple)
    listed: Entry | None = None


@dataclass(frozen=True)
class IndexedSpecimen:
    """What the index holds of all recordings of a specimen with fits.

    identifiers: oldest first; first, last: begin of the oldest and the newest, ISO 8601; shots: that were fitted;
    resonators: recordings by name, the one that was measured last first; calibrations: recordings by name of the
    receive calibration, without those that name none; tags: in the order of the alphabet.
    """

    identifiers: Sequence[str]
    first: str
    last: str
    shots: int
    resonators: Mapping[str, int]
    calibrations: Mapping[str, int]
    tags: Sequence[str]


@dataclass(frozen=True)
class IndexedSummary:
    """What a list says of a recording: its sample and resonator, frames by verdict, and the means of its good fits.

    None: not known.
    """

    sample: str | None
    resonator: str | None
    good: int
    refused: int
    f_nat_hz: float | None
    m_r_am2: float | None


@dataclass(frozen=True)
class IndexUpdate:
    """looked: how many files were read; specimens: names of those whose recordings were added, changed or deleted;
    in_use: how many files could not be read now, as those that another program has open, and are to be read again.
    """

    looked: int
    specimens: frozenset[str]
    in_use: int = 0


@dataclass(frozen=True)
class Wanted:
    """A filter of recordings; an attribute that is None matches everything.

    specimen: name of the sample; operator: part of the name, in any case; since, until: ISO 8601 in UTC, of the begin;
    refused: True: those with a shot that was refused, False: those without; tag: with or without its #; resonator:
    its name.
    """

    specimen: str | None = None
    operator: str | None = None
    since: str | None = None
    until: str | None = None
    refused: bool | None = None
    tag: str | None = None
    resonator: str | None = None
