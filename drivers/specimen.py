"""A resonator specimen as its TOML file declares it: design values, measured values, pose on the clamping unit."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from drivers.uncertainty import DeclaredUncertainty, Influence

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Coordinate = Annotated[float, Field(ge=-1.0, le=1.0, allow_inf_nan=False)]
Position = Annotated[tuple[Coordinate, Coordinate, Coordinate], Field(strict=False)]
Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]
SmallAngle = Annotated[float, Field(ge=0, le=0.1, allow_inf_nan=False)]
Tilt = Annotated[float, Field(ge=-0.6, le=0.6, allow_inf_nan=False)]
Length = Annotated[float, Field(ge=-1e-2, le=1e-2, allow_inf_nan=False)]
DOWN = (0.0, 0.0, -9.81)  # m/s^2, world axes
Offset = Annotated[tuple[Length, Length], Field(strict=False)]


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

    f_nat_hz: Positive | None = Field(default=None, description="Natural frequency at small angles, Hz.")
    m_r_am2: Positive | None = Field(default=None, description="Magnetic moment of the rotor, A m^2.")
    lambda_per_s: NonNegative | None = Field(
        default=None,
        description="Viscous damping, 1/s; it has no design equation. A simulated resonator without it has the paper's "
        "of its bearing.",
    )
    tf_over_i_rad_per_s2: NonNegative | None = Field(
        default=None, description="Dry friction torque over moment of inertia, rad/s^2; of a jewel bearing only."
    )


class Pose(_Section):
    """Pose on the platform."""

    position_m: Position = Field((0.0, 0.0, 0.0), description="Position of the rotor, m, each at most 1.")
    rodrigues_rad: Vector = Field(description="Rodrigues vector, rad, from u, v, w to world axes.")


class RotorModel(_Section):
    """How the simulated platform moves the rotor; fits read of it only whether a jewel's rotor has a weight."""

    model: Literal["single_axis", "rigid_body"] = Field(
        description="single_axis: one angle about the main axis; rigid_body: five degrees of freedom, with side modes."
    )
    side_damping_per_s: NonNegative = Field(
        default=0.0, description="Viscous damping of the side modes, 1/s; rigid_body only."
    )
    gravity_m_per_s2: Vector = Field(
        default=DOWN, description="Acceleration of gravity in world axes, m/s^2; rigid_body only."
    )
    orientation_scatter_rad: SmallAngle | Annotated[tuple[SmallAngle, SmallAngle, SmallAngle], Field(strict=False)] = (
        Field(
            default=0.0,
            description="Standard deviation by which the resonator is turned in every shot, rad: about each of u, v "
            "and w, or three values.",
        )
    )
    f_nat_scatter_hz: Annotated[float, Field(ge=0, le=10, allow_inf_nan=False)] = Field(
        default=0.0, description="Standard deviation of the natural frequency from shot to shot, Hz."
    )
    lambda_scatter: Annotated[float, Field(ge=0, le=0.3, allow_inf_nan=False)] = Field(
        default=0.0, description="Standard deviation of the viscous damping from shot to shot, as a share of it."
    )
    undeclared: Annotated[tuple[dict[str, bool | int | float | str], ...], Field(strict=False)] = Field(
        default=(),
        description="Effects that come with this resonator, as the tables backends.simulated.undeclared of a platform.",
    )


class Defects(_Section):
    """Manufacturing errors (paper, "Types of manufacturing errors in MMRs"); tilts are about v.  rigid_body only."""

    stator_tilt_rad: Tilt = Field(default=0.0, description="Tilt of the stator's moment, rad.")
    rotor_tilt_rad: Tilt = Field(
        default=0.0, description="Tilt of the rotor's moment against the thread, rad; thread only."
    )
    jewel_tilt_rad: Tilt = Field(default=0.0, description="Tilt of the jewel, rad; jewel only.")
    jewel_tilt_pivot: Literal["contact", "rotor", "stator"] = Field(
        default="contact",
        description="Where the jewel is tilted about: first contact point, rotor's centre, stator's centre.",
    )
    stator_offset_m: Offset = Field(
        default=(0.0, 0.0), description="Lateral displacement of the stator along u and v, m."
    )


class Measurand(_Section):
    """What the specimen is a sensor for; `platform-daemon measurand calibrate` finds how its frequency follows it."""

    name: str = Field(min_length=1, max_length=100, description="The quantity in words, as pressure.")
    unit: str = Field(min_length=1, max_length=30, description="Its unit, as mbar.")
    model: str = Field(
        default="polynomial",
        min_length=1,
        description="polynomial; dipole: f proportional to (x + x0)^(-3/2), x a distance; or the name of an entry "
        "point of the group platform_daemon.measurand_models.",
    )
    degree: Annotated[int, Field(ge=1, le=5)] = Field(default=1, description="Of the polynomial.")
    corrected_for: Literal["temperature"] | None = Field(
        default=None, description="A second influence whose coefficient is calibrated, too; null: none."
    )
    reference: Influence | None = Field(
        default=None,
        description="What all readings of the reference have in common, as its certificate says, in `unit`; null: not "
        "declared.",
    )
    longest_lag_s: NonNegative = Field(
        default=0.0, description="The resonator may follow the reference, or precede it, by as much, s; 0: by nothing."
    )
    lowest: Annotated[float, Field(allow_inf_nan=False)] | None = Field(
        default=None, description="An alarm is raised for readings below it, in `unit`; null: none."
    )
    highest: Annotated[float, Field(allow_inf_nan=False)] | None = Field(
        default=None, description="An alarm is raised for readings above it, in `unit`; null: none."
    )
    expected_from: Annotated[float, Field(allow_inf_nan=False)] | None = Field(
        default=None,
        description="A reference of which no reading lies from here to `expected_to` is refused, and no other rule "
        "judges their unit; in `unit`; null: nothing is expected.",
    )
    expected_to: Annotated[float, Field(allow_inf_nan=False)] | None = Field(
        default=None, description="See `expected_from`; both are given, or neither."
    )

    @model_validator(mode="after")
    def _limits_in_order(self) -> Measurand:
        if self.lowest is not None and self.highest is not None and self.highest <= self.lowest:
            raise ValueError("highest is not above lowest: no reading is between them")
        if (self.expected_from is None) != (self.expected_to is None):
            raise ValueError("expected_from and expected_to are given together")
        if self.expected_from is not None and self.expected_to is not None and self.expected_to <= self.expected_from:
            raise ValueError("expected_to is not above expected_from: no reading is between them")
        return self


class SideModeLimit(_Section):
    """Up to which field the resonator moves as its equation of motion says, as a ramp has found it (paper, "Measurement
    Sequence")."""

    max_field_t: Positive = Field(description="Highest field it is to see, T.")
    operating_field_t: Positive = Field(description="Field at which it is to be used, T.")
    found: str = Field(min_length=1, description="When it was found, ISO 8601.")
    evidence: str = Field(min_length=1, description="How it was found: job, threshold and its interval.")
    job: str | None = Field(None, description="Id of the ramp that found it; null: not recorded.")


class Specimen(_Section):
    """One resonator (paper eq:Thread_ODE_norm, eq:Jewel_ODE_norm)."""

    name: str = Field(min_length=1, description="Its name in words.")
    variant: Literal["thread", "jewel"] = Field(description="Its bearing, which decides the equation of motion.")
    magnets: Magnets
    jewel: JewelBearing | None = Field(None, description="The cup of a jewel bearing; null: it is a thread.")
    thread: ThreadBearing | None = Field(None, description="The thread; null: it is a jewel bearing.")
    measured: Measured = Field(Measured(), description="Values measured on this specimen; none: it is new.")
    pose: Pose
    rotor: RotorModel = Field(
        RotorModel(model="single_axis"), description="How the simulated platform moves the rotor."
    )
    defects: Defects | None = Field(None, description="Manufacturing errors; null: none.")
    side_modes: SideModeLimit | None = Field(None, description="What a ramp has found; null: none was made.")
    uncertainty: DeclaredUncertainty | None = Field(
        default=None,
        description="How well influences are known, in the place of what the platform's file says; null: not said.",
    )

    measurand: Measurand | None = Field(
        default=None, description="What the specimen is a sensor for; null: for nothing but itself."
    )

    @model_validator(mode="after")
    def _bearing_fits_variant(self) -> Specimen:
        if (self.jewel is None) != (self.variant == "thread") or (self.thread is None) != (self.variant == "jewel"):
            raise ValueError(f"a {self.variant} resonator needs the table [{self.variant}] and no other bearing")
        if self.variant == "thread" and self.measured.tf_over_i_rad_per_s2:
            raise ValueError("the thread's equation of motion has no dry friction: leave tf_over_i_rad_per_s2 out")
        return self

    @model_validator(mode="after")
    def _defects_fit_rotor(self) -> Specimen:
        given = {
            "[defects]": self.defects is not None,
            "rotor.side_damping_per_s": self.rotor.side_damping_per_s > 0,
            "rotor.gravity_m_per_s2": self.rotor.gravity_m_per_s2 != DOWN,
        }
        if self.rotor.model == "single_axis" and any(given.values()):
            found = ", ".join(name for name, there in given.items() if there)
            raise ValueError(f"{found}: a single_axis rotor has no side modes; choose rotor.model = 'rigid_body'")
        if self.defects is not None and self.variant == "thread" and self.defects.jewel_tilt_rad:
            raise ValueError("a thread resonator has no jewel: leave defects.jewel_tilt_rad out")
        if self.defects is not None and self.variant == "jewel" and self.defects.rotor_tilt_rad:
            raise ValueError("a jewel's rotor aligns itself: leave defects.rotor_tilt_rad out")
        return self
