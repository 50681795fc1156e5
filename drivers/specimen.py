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
    """The two spheres (paper eq:m_r, eq:fnat)."""

    radius_m: Positive = Field(description="Radius of each sphere, m.")
    remanence_t: Positive = Field(description="Remanence, T.")
    density_kg_per_m3: Positive = Field(description="Density, kg/m^3.")
    distance_m: Positive = Field(description="Distance of their centres, m.")


class JewelBearing(_Section):
    """The cup (paper eq:a, eq:tf(phi))."""

    cup_radius_m: Positive = Field(description="Radius of the cup, m.")
    youngs_modulus_jewel_pa: Positive = Field(description="Young's modulus of the jewel, Pa.")
    youngs_modulus_coating_pa: Positive = Field(description="Young's modulus of the coating, Pa.")
    poissons_ratio: float = Field(ge=0, lt=0.5, description="Poisson's ratio.")
    friction_coefficient: NonNegative = Field(description="Coefficient of sliding friction.")


class ThreadBearing(_Section):
    """The thread."""

    length_m: Positive = Field(description="Length, m.")


class Measured(_Section):
    """Values measured on this specimen; each overrides the design value, null: the design value holds."""

    f_nat_hz: Positive | None = Field(None, description="Natural frequency at small angles, Hz.")
    m_r_am2: Positive | None = Field(None, description="Magnetic moment of the rotor, A m^2.")
    lambda_per_s: NonNegative = Field(description="Viscous damping, 1/s; it has no design equation.")
    tf_over_i_rad_per_s2: NonNegative | None = Field(
        None, description="Dry friction torque over moment of inertia, rad/s^2; of a jewel bearing only."
    )


class Pose(_Section):
    """Pose on the platform."""

    position_m: Position = Field((0.0, 0.0, 0.0), description="Position of the rotor, m, each at most 1.")
    rodrigues_rad: Vector = Field(description="Rodrigues vector, rad, from u, v, w to world axes.")


class Specimen(_Section):
    """One resonator (paper eq:Thread_ODE_norm, eq:Jewel_ODE_norm)."""

    name: str = Field(min_length=1, description="Its name in words.")
    variant: Literal["thread", "jewel"] = Field(description="Its bearing, which decides the equation of motion.")
    magnets: Magnets
    jewel: JewelBearing | None = Field(None, description="The cup of a jewel bearing; null: it is a thread.")
    thread: ThreadBearing | None = Field(None, description="The thread; null: it is a jewel bearing.")
    measured: Measured
    pose: Pose

    @model_validator(mode="after")
    def _bearing_fits_variant(self) -> Specimen:
        if (self.jewel is None) != (self.variant == "thread") or (self.thread is None) != (self.variant == "jewel"):
            raise ValueError(f"a {self.variant} resonator needs the table [{self.variant}] and no other bearing")
        if self.variant == "thread" and self.measured.tf_over_i_rad_per_s2:
            raise ValueError("the thread's equation of motion has no dry friction: leave tf_over_i_rad_per_s2 out")
        return self
