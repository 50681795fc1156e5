"""What every undeclared effect has in common."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import Field

from sim_backend.section import Finite, Section

Time = Annotated[float, Field(gt=1e-6, allow_inf_nan=False)]


class Effect(Section):
    """One undeclared effect.  UNIT: of its strength; ONCE: it may stand in the list only once."""

    UNIT: ClassVar[str]
    ONCE: ClassVar[bool] = True
    strength: Finite

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON types: id, strength, unit, and the other keys that are set."""
        keys = self.model_dump(mode="json", by_alias=True, exclude_none=True)
        return {"id": keys.pop("id"), "strength": keys.pop("strength"), "unit": self.UNIT, **keys}
