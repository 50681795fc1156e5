"""An adopted model: a declared one with further torque terms, and what is undone on the receive side."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from typing import Any

from drivers.calibration import ReceiverEffect
from platform_daemon.estimation import TERMS, RingDownModel, model_named
from platform_daemon.schemas import (
    AdoptedModelRecord,
    AdoptedModelReport,
    AdoptedModelSummary,
    AdoptedTermRecord,
    AdoptionEvidence,
    ReceiverEffectRecord,
    Retirement,
)


def held(term: AdoptedTermRecord) -> dict[str, float]:
    """Coefficients that fits do not estimate: all, or only a free term's hidden scale."""
    return {c.name: term.values[c.name] for c in TERMS[term.term].coefficients if c.hidden or not term.free}


@dataclass(frozen=True)
class AdoptedModel:
    """A named, versioned model.

    Attributes:
        name, version: version 0: not in a library yet.
        base: the declared model, as estimation names it.
        terms, receiver: what was added to it, and what is undone in the samples before a fit.
        evidence: the diagnosis, the recordings with their digests, who adopted it, when and with which software; of
            another version of this software: as it stands in the file.
        retired: None, or who retired it, when and why.
    """

    name: str
    version: int
    base: str
    terms: tuple[AdoptedTermRecord, ...] = ()
    receiver: tuple[ReceiverEffect, ...] = ()
    evidence: AdoptionEvidence | dict[str, Any] = field(default_factory=dict, compare=False, hash=False)
    retired: Retirement | None = field(default=None, compare=False, hash=False)

    @property
    def label(self) -> str:
        """What results and recordings are marked with."""
        return f"{self.name}@{self.version}"

    def __getstate__(self) -> dict[str, Any]:
        """On its way to another process: what it is, not what was made of it, which holds compiled code."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @cached_property
    def model(self) -> RingDownModel:
        """What a fit takes; held strengths are the model's knowledge.  Raises ValueError for unknown names."""
        unknown = [t.term for t in self.terms if t.term not in TERMS]
        if unknown:
            raise ValueError(f"unknown torque term {unknown[0]!r}")
        model = model_named(self.base).with_terms(self.label, *(TERMS[t.term] for t in self.terms))
        values = {name: value for t in self.terms for name, value in held(t).items()}
        known = tuple(replace(model.parameters[name], fixed=value) for name, value in values.items())
        return replace(model, known=(*model.known, *known))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of everything that a fit depends on."""
        return hashlib.sha256(json.dumps(self._physics(), sort_keys=True).encode()).hexdigest()

    def _physics(self) -> dict[str, Any]:
        terms = [t.model_dump() for t in self.terms]
        return {"base": self.base, "terms": terms, "receiver": [asdict(r) for r in self.receiver]}

    def record(self) -> AdoptedModelRecord:
        """The content of its file."""
        return AdoptedModelRecord(
            format="platform-daemon adopted model 1",
            name=self.name,
            version=self.version,
            label=self.label,
            base=self.base,
            terms=self.terms,
            receiver=tuple(ReceiverEffectRecord(**asdict(r)) for r in self.receiver),
            digest=self.digest,
            evidence=self.evidence,
        )

    def report(self) -> AdoptedModelReport:
        """Everything."""
        return AdoptedModelReport(**dict(self.record()), retired=self.retired)

    def summary(self) -> AdoptedModelSummary:
        """One line of a list."""
        known = self.evidence if isinstance(self.evidence, AdoptionEvidence) else None
        return AdoptedModelSummary(
            label=self.label,
            name=self.name,
            version=self.version,
            base=self.base,
            terms=tuple(t.term for t in self.terms),
            receiver=tuple(r.id for r in self.receiver),
            adopted_at=None if known is None else known.adopted_at,
            adopted_by=None if known is None else known.adopted_by,
            digest=self.digest,
            retired=self.retired,
        )


def from_record(record: AdoptedModelRecord) -> AdoptedModel:
    """Raises ValueError for a record that was changed by hand, or names what this software does not know."""
    found = AdoptedModel(
        name=record.name,
        version=record.version,
        base=record.base,
        terms=record.terms,
        receiver=tuple(ReceiverEffect(**r.model_dump()) for r in record.receiver),
        evidence=record.evidence,
    )
    if found.digest != record.digest:
        raise ValueError("its digest does not match: the file was changed after it was adopted")
    found.model  # noqa: B018  raises for names that this software does not know
    return found
