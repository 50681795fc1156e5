"""Stores what a ramp has found: as a new version of the resonator in the catalogue, or a file next to the recording."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from drivers.specimen import SideModeLimit, Specimen
from platform_daemon.core.hardware.catalogue import Catalogue, to_toml
from platform_daemon.core.state.durable import write_file

from .schema import RampOutcome

Keep = Callable[[RampOutcome, str], str]
"""Keeps an outcome under the id of its job; returns where."""


def with_limit(specimen: Specimen, outcome: RampOutcome, job: str) -> Specimen | None:
    """The specimen with what the ramp has found; None: it found no threshold."""
    t = outcome.threshold_t
    if t is None or outcome.max_field_t is None or outcome.operating_field_t is None:
        return None
    limit = SideModeLimit(
        max_field_t=outcome.max_field_t,
        operating_field_t=outcome.operating_field_t,
        found=datetime.now(UTC).isoformat(timespec="seconds"),
        evidence=f"ramp {job}: threshold {1e6 * t.value:.4g} uT, {1e6 * t.low:.4g} to {1e6 * t.high:.4g} uT",
        job=job,
    )
    return specimen.model_copy(update={"side_modes": limit})


def save_to_catalogue(catalogue: Catalogue, name: str) -> Keep:
    """Store a new version of the resonator `name`, which is used from then on."""

    def keep(outcome: RampOutcome, job: str) -> str:
        found = with_limit(catalogue.resonators.named(name), outcome, job)
        base = name.partition("@")[0]
        return "" if found is None else catalogue.resonators.add(base, found, in_its_place=True).path.name

    return keep


def save_with_recording(specimen: Specimen, target: Path) -> Keep:
    """As a resonator file of its own, TARGET.toml."""

    def keep(outcome: RampOutcome, job: str) -> str:
        found = with_limit(specimen, outcome, job)
        if found is not None:
            write_file(target, to_toml(found.model_dump(exclude_none=True)).encode())
        return "" if found is None else target.name

    return keep
