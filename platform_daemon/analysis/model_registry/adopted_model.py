"""An adopted model: a declared one with further torque terms, and what is undone on the receive side."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

from drivers.calibration import ReceiverEffect
from platform_daemon.estimation import TERMS, RingDownModel, model_named

FORMAT = "platform-daemon adopted model 1"


@dataclass(frozen=True)
class AdoptedTerm:
    """A further torque term.

    Attributes:
        term: its name in estimation/physics/torques.
        values, std: of its coefficients by their public names; std None: not estimated.
        free: fits estimate the strength anew; else they hold it.
    """

    term: str
    values: Mapping[str, float]
    std: Mapping[str, float | None]
    free: bool = False

    def held(self) -> dict[str, float]:
        """Coefficients that fits do not estimate: all, or only a free term's hidden scale."""
        return {c.name: self.values[c.name] for c in TERMS[self.term].coefficients if c.hidden or not self.free}


@dataclass(frozen=True)
class AdoptedModel:
    """A named, versioned model.

    Attributes:
        name, version: version 0: not in a library yet.
        base: the declared model, as estimation names it.
        terms, receiver: what was added to it, and what is undone in the samples before a fit.
        evidence: the diagnosis, the recordings with their digests, who adopted it, when and with which software.
        retired: None, or who retired it, when and why.
    """

    name: str
    version: int
    base: str
    terms: tuple[AdoptedTerm, ...] = ()
    receiver: tuple[ReceiverEffect, ...] = ()
    evidence: Mapping[str, Any] = field(default_factory=dict, compare=False, hash=False)
    retired: Mapping[str, Any] | None = field(default=None, compare=False, hash=False)

    @property
    def label(self) -> str:
        """What results and recordings are marked with."""
        return f"{self.name}@{self.version}"

    @cached_property
    def model(self) -> RingDownModel:
        """What a fit takes; held strengths are the model's knowledge.  Raises ValueError for unknown names."""
        unknown = [t.term for t in self.terms if t.term not in TERMS]
        if unknown:
            raise ValueError(f"unknown torque term {unknown[0]!r}")
        model = model_named(self.base).with_terms(self.label, *(TERMS[t.term] for t in self.terms))
        held = {name: value for t in self.terms for name, value in t.held().items()}
        known = tuple(replace(model.parameters[name], fixed=value) for name, value in held.items())
        return replace(model, known=(*model.known, *known))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of everything that a fit depends on."""
        return hashlib.sha256(json.dumps(self._physics(), sort_keys=True).encode()).hexdigest()

    def _physics(self) -> dict[str, Any]:
        terms = [{**asdict(t), "values": dict(t.values), "std": dict(t.std)} for t in self.terms]
        return {"base": self.base, "terms": terms, "receiver": [asdict(r) for r in self.receiver]}

    def as_json(self) -> dict[str, Any]:
        """Everything, with the digest."""
        head = {"format": FORMAT, "name": self.name, "version": self.version, "label": self.label}
        return {**head, **self._physics(), "digest": self.digest, "evidence": dict(self.evidence)}

    def summary(self) -> dict[str, Any]:
        """One line of a list."""
        return {
            "label": self.label,
            "name": self.name,
            "version": self.version,
            "base": self.base,
            "terms": [t.term for t in self.terms],
            "receiver": [r.id for r in self.receiver],
            "adopted_at": self.evidence.get("adopted_at"),
            "adopted_by": self.evidence.get("adopted_by"),
            "digest": self.digest,
            "retired": None if self.retired is None else dict(self.retired),
        }


def from_json(record: Mapping[str, Any]) -> AdoptedModel:
    """Raises ValueError, KeyError, TypeError for something else, or a record that was changed by hand."""
    if record["format"] != FORMAT:
        raise ValueError(f"its format is {record['format']!r}, expected {FORMAT!r}")
    found = AdoptedModel(
        name=record["name"],
        version=int(record["version"]),
        base=record["base"],
        terms=tuple(AdoptedTerm(**t) for t in record["terms"]),
        receiver=tuple(ReceiverEffect(**r) for r in record["receiver"]),
        evidence=record["evidence"],
    )
    if found.digest != record["digest"]:
        raise ValueError("its digest does not match: the file was changed after it was adopted")
    found.model  # noqa: B018  raises for names that this software does not know
    return found
