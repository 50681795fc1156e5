"""What every hidden effect has in common."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import Field

from sim_backend.section import Finite, Section

Time = Annotated[float, Field(gt=1e-6, allow_inf_nan=False)]


class Effect(Section):
    """One hidden effect.

    UNIT: unit of the strength; ONCE: the effect may occur only once in the list; strength: its size, in UNIT.
    """

    UNIT: ClassVar[str]
    ONCE: ClassVar[bool] = True
    strength: Finite

    def as_dict(self) -> dict[str, Any]:
        """The effect as plain JSON types: id, strength, unit, and the other keys that are set."""
        keys = self.model_dump(mode="json", by_alias=True, exclude_none=True)
        return {"id": keys.pop("id"), "strength": keys.pop("strength"), "unit": self.UNIT, **keys}
