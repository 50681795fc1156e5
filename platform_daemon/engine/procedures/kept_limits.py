"""What a ramp has found is kept with the specimen: a new version in the catalogue, or a file beside the recording."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from drivers.specimen import SideModeLimit, Specimen
from platform_daemon.schemas import RampOutcome
from platform_daemon.store import write_file

from ..catalogue import Catalogue, to_toml

Keep = Callable[[RampOutcome, str], str]
"""Keeps an outcome under the id of its job; returns where."""


def with_limit(specimen: Specimen, outcome: RampOutcome, job: str) -> Specimen | None:
    """The specimen with what the ramp has found; None: it found nothing."""
    if outcome.max_field_t is None or outcome.operating_field_t is None:
        return None
    t = outcome.threshold_t
    said = "no side modes up to there" if t is None else f"threshold {1e6 * t.value:.4g} uT"
    interval = "" if t is None else f", {1e6 * t.low:.4g} to {1e6 * t.high:.4g} uT"
    limit = SideModeLimit(
        max_field_t=outcome.max_field_t,
        operating_field_t=outcome.operating_field_t,
        found=datetime.now(UTC).isoformat(timespec="seconds"),
        evidence=f"ramp {job}: {said}{interval}",
    )
    return specimen.model_copy(update={"side_modes": limit})


def keep_in(catalogue: Catalogue, name: str) -> Keep:
    """As a new version of the resonator `name`, which stands for it from then on."""

    def keep(outcome: RampOutcome, job: str) -> str:
        found = with_limit(catalogue.resonators.named(name), outcome, job)
        return "" if found is None else catalogue.resonators.add(name, found, in_its_place=True).path.name

    return keep


def keep_beside(specimen: Specimen, target: Path) -> Keep:
    """As a resonator file of its own, TARGET.toml."""

    def keep(outcome: RampOutcome, job: str) -> str:
        found = with_limit(specimen, outcome, job)
        if found is not None:
            write_file(target, to_toml(found.model_dump(exclude_none=True)).encode())
        return "" if found is None else target.name

    return keep
