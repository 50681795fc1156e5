"""An adopted model: a declared one with further torque terms, and what is undone on the receive side."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from drivers.calibration import ReceiverEffect
from drivers.errors import InputError
from platform_daemon.core.schemas.model_names import TORQUE_TERMS, check_model_name

from .schema import (
    AdoptedModelRecord,
    AdoptedModelReport,
    AdoptedModelSummary,
    AdoptedRotorRecord,
    AdoptedTermRecord,
    AdoptionEvidence,
    ReceiverEffectRecord,
    Retirement,
)

if TYPE_CHECKING:
    from platform_daemon.estimation.physics.models import RingDownModel


def _own_coefficients(name: str) -> tuple[str, ...]:
    """Of a torque term of another package.  Raises ValueError if it cannot be used."""
    from platform_daemon.estimation.physics.torques import BROKEN, TERMS  # here, because numba is loaded with it

    if name not in TERMS:
        raise ValueError(f"torque term {name!r} cannot be used: {BROKEN.get(name, 'its package is not installed')}")
    return tuple(c.name for c in TERMS[name].coefficients)


def held(term: AdoptedTermRecord) -> dict[str, float]:
    """Coefficients that fits do not estimate: all, or only a free term's hidden scale."""
    from platform_daemon.estimation.physics.torques import TERMS  # here, because numba is loaded with it

    return {c.name: term.values[c.name] for c in TERMS[term.term].coefficients if c.hidden or not term.free}


@dataclass(frozen=True)
class AdoptedModel:
    """A named, versioned model.

    Attributes:
        name, version: version 0: not in a library yet.
        base: the declared model, as estimation names it.
        terms, receiver: what was added to it, and what is undone in the samples before a fit.
        rotor: None, or the manufacturing error with which fits take a rotor of five degrees of freedom.
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
    rotor: AdoptedRotorRecord | None = None

    @property
    def label(self) -> str:
        """What results and recordings are marked with."""
        return f"{self.name}@{self.version}"

    def __getstate__(self) -> dict[str, Any]:
        """On its way to another process: what it is, not what was made of it, which holds compiled code."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @cached_property
    def model(self) -> RingDownModel:
        """What a fit takes; held strengths are the model's knowledge.

        Raises ValueError for unknown names, InputError for a manufacturing error, which one angle cannot hold.
        """
        from platform_daemon.estimation.physics.models import model_named
        from platform_daemon.estimation.physics.torques import TERMS  # here, because numba is loaded with it

        self.check()
        self.refuse_rotor()
        model = model_named(self.base).with_terms(self.label, *(TERMS[t.term] for t in self.terms))
        values = {name: value for t in self.terms for name, value in held(t).items()}
        known = tuple(replace(model.parameters[name], fixed=value) for name, value in values.items())
        return replace(model, known=(*model.known, *known))

    def refuse_rotor(self) -> None:
        """Raises InputError if it holds a manufacturing error: where it cannot be used, one angle must not stand in."""
        if self.rotor is None:
            return
        why = f"it holds {self.rotor.id}; this takes a model of one angle, and a fit with five degrees takes seconds"
        remedy = f"use {self.base} here, and fit the recordings with it: platform-daemon fit --variant {self.label}"
        raise InputError(f"{self.label} cannot be used here", where="variant", why=why, remedy=remedy)

    @property
    def one_angle(self) -> AdoptedModel:
        """The same without its manufacturing error: where fits of the rotor start."""
        return replace(self, rotor=None)

    @property
    def diagnosed(self) -> dict[str, float]:
        """What the diagnosis has found with it, by public name: means over its shots that are not 0."""
        evidence: Any = self.evidence if isinstance(self.evidence, dict) else self.evidence.model_dump()
        after = evidence.get("diagnosis", {}).get("parameters_after", {})
        return {name: each["value"] for name, each in after.items() if each and each.get("value")}

    def check(self) -> None:
        """Check the names and the strengths that are held, without loading what the names stand for.

        Raises ValueError for a name that this software does not know, and for a strength that is missing.
        """
        check_model_name("+".join((self.base, *(t.term for t in self.terms))))
        for each in self.terms:
            coefficients = TORQUE_TERMS.get(each.term) or _own_coefficients(each.term)
            missing = [name for name in coefficients[1 if each.free else 0 :] if name not in each.values]
            if missing:
                raise ValueError(f"torque term {each.term!r} has no value of {missing[0]!r}")

    @cached_property
    def digest(self) -> str:
        """SHA-256 of everything that a fit depends on."""
        return hashlib.sha256(json.dumps(self._physics(), sort_keys=True).encode()).hexdigest()

    def _physics(self) -> dict[str, Any]:
        terms = [t.model_dump() for t in self.terms]
        found = {"base": self.base, "terms": terms, "receiver": [asdict(r) for r in self.receiver]}
        return found if self.rotor is None else {**found, "rotor": self.rotor.model_dump()}

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
            rotor=self.rotor,
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
            terms=(*(t.term for t in self.terms), *([] if self.rotor is None else [self.rotor.id])),
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
        rotor=record.rotor,
    )
    if found.digest != record.digest:
        raise ValueError("its digest does not match: the file was changed after it was adopted")
    found.check()
    return found
