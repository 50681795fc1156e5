"""What users ask for."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class SelfTestOptions(BaseModel):
    """Table `[self_test]` of a platform file.

    enabled: None: on for real devices, off for a platform that lives in simulated time; amplifier_v: on each coil;
    frequency_hz: far above any resonator, so that none is moved; isolation_db: of the switch at that frequency, None:
    unknown, the channels are compared with each other; tolerance: of the gain, relative.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    enabled: bool | None = None
    amplifier_v: Positive = 1.0
    frequency_hz: Positive = 4000.0
    tone_s: Annotated[float, Field(ge=4e-3, le=1.0)] = 12e-3
    isolation_db: Annotated[float, Field(ge=0, le=200)] | None = None
    tolerance: Annotated[float, Field(gt=0, lt=1)] = 0.3
