"""The numbers of the paper and the measured ones."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from typing_extensions import TypeAliasType

from platform_daemon.core.schemas.base import QueuedRequest, Schema

QUICK_SHOTS = 10
"""Of each resonator in a quick campaign."""
ClaimVerdict = TypeAliasType("ClaimVerdict", Literal["agrees", "differs", "not_reproducible"])
"""Of a number of the paper."""


class Claim(Schema):
    """A number of the paper, or a statement ("yes" or "no"), and the measured one."""

    label: str
    """LaTeX label of the equation, table, figure or section in the paper."""
    what: str
    """What it is, with its unit."""
    paper: float | str
    """As the paper has it."""
    ours: float | str | None
    """As it was computed here; null: it was not."""
    u: float | None
    """Standard error of ours; null: it has none, as of a computed number."""
    tolerance: float | None
    """By how much the two may differ; null: of a statement, or of what cannot be compared."""
    verdict: ClaimVerdict
    """agrees: within the tolerance; not_reproducible: there is nothing to compare, see `why`."""
    why: str
    """How the tolerance follows, or why there is nothing to compare."""
    command: str
    """What computes ours."""


class Claims(Schema):
    """What `claims.json` holds."""

    claims: tuple[Claim, ...]
    """In the order of the paper."""


class Campaign(Schema):
    """What a folder of a campaign was measured with; another version does not continue it."""

    software_version: str
    """Version of the software."""
    platform: str
    """Platform, as it was named: a shipped one, or a file."""
    changes: tuple[str, ...]
    """What differed from its file (--set)."""
    shots: int
    """Shots of each resonator."""
    tune: bool
    """f_nat and the sequence were found first."""
    ramp: bool
    """The field was found by a ramp."""
    quick: bool
    """The ramps began at 80 % of the paper's field, and had larger steps."""

    @property
    def finds_field(self) -> bool:
        """By a ramp."""
        return self.ramp


class ReproductionRequest(QueuedRequest):
    """The paper's campaign: both resonators, and each of its numbers beside the measured one."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"quick": True}]})

    thread: Annotated[str, Field(min_length=1, max_length=500)] | None = "thread_published"
    """Resonator that is the thread, of GET /resonators; null: it is left out."""
    jewel: Annotated[str, Field(min_length=1, max_length=500)] | None = "jewel_published"
    """Resonator that is the jewel; null: it is left out."""
    shots: Annotated[int, Field(ge=2, le=100_000)] = 100
    """Shots of each resonator."""
    quick: bool = False
    """10 shots of each, fewer fields of the ramps; wider tolerances."""
    tune: bool = True
    """Find f_nat first."""
    ramp: bool = True
    """Find the field first, 80 % of that of side modes."""

    @model_validator(mode="after")
    def _one_is_left(self) -> ReproductionRequest:
        if not self.resonators:
            raise ValueError("no resonator is left: name thread or jewel")
        return self

    @property
    def resonators(self) -> dict[str, str]:
        """Names by variant, in the order in which they are measured."""
        return {v: name for v, name in (("thread", self.thread), ("jewel", self.jewel)) if name is not None}

    def campaign(self, software_version: str) -> Campaign:
        """What it measures, on the platform of a daemon of that version."""
        return Campaign(
            software_version=software_version,
            platform="",
            changes=(),
            shots=QUICK_SHOTS if self.quick else self.shots,
            tune=self.tune,
            ramp=self.ramp,
            quick=self.quick,
        )

    @property
    def mounted_resonator(self) -> str | None:
        """See QueuedRequest."""
        names = list(self.resonators.values())
        return names[0] if len(names) == 1 else None
