"""A resonator specimen as its TOML file declares it: design values, measured values, pose on the clamping unit."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Coordinate = Annotated[float, Field(ge=-1.0, le=1.0, allow_inf_nan=False)]
Position = Annotated[tuple[Coordinate, Coordinate, Coordinate], Field(strict=False)]
Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Magnets(_Section):
    """The two spheres (paper eq:m_r, eq:fnat): radius m, remanence T, density kg/m^3, centre distance m."""

    radius_m: Positive
    remanence_t: Positive
    density_kg_per_m3: Positive
    distance_m: Positive


class JewelBearing(_Section):
    """The cup (paper eq:a, eq:tf(phi)): radius m, Young's moduli Pa, Poisson's ratio, sliding friction coefficient."""

    cup_radius_m: Positive
    youngs_modulus_jewel_pa: Positive
    youngs_modulus_coating_pa: Positive
    poissons_ratio: Annotated[float, Field(ge=0, lt=0.5)]
    friction_coefficient: NonNegative


class ThreadBearing(_Section):
    """The thread: length m."""

    length_m: Positive


class Measured(_Section):
    """Values measured on this specimen; each overrides the design value, None: the design value holds.

    lambda_per_s has no design equation and must be given.
    """

    f_nat_hz: Positive | None = None
    m_r_am2: Positive | None = None
    lambda_per_s: NonNegative
    tf_over_i_rad_per_s2: NonNegative | None = None


class Pose(_Section):
    """Pose on the platform: position of the rotor m (at most 1 m), Rodrigues vector rad (u, v, w to world)."""

    position_m: Position = (0.0, 0.0, 0.0)
    rodrigues_rad: Vector


class Specimen(_Section):
    """One resonator; `variant` decides the equation of motion (paper eq:Thread_ODE_norm, eq:Jewel_ODE_norm)."""

    name: Annotated[str, Field(min_length=1)]
    variant: Literal["thread", "jewel"]
    magnets: Magnets
    jewel: JewelBearing | None = None
    thread: ThreadBearing | None = None
    measured: Measured
    pose: Pose

    @model_validator(mode="after")
    def _bearing_fits_variant(self) -> Specimen:
        if (self.jewel is None) != (self.variant == "thread") or (self.thread is None) != (self.variant == "jewel"):
            raise ValueError(f"a {self.variant} resonator needs the table [{self.variant}] and no other bearing")
        if self.variant == "thread" and self.measured.tf_over_i_rad_per_s2:
            raise ValueError("the thread's equation of motion has no dry friction: leave tf_over_i_rad_per_s2 out")
        return self
