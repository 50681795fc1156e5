"""What design equations and statics say of a resonator: numbers of its design, and forces of manufacturing defects."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, WithJsonSchema, model_validator
from typing_extensions import TypeAliasType

from platform_daemon.core.schemas.base import (
    Absent,
    Finite,
    Request,
    Schema,
    Vector,
    example,
)
from platform_daemon.core.schemas.requests import ModelName

_Quarter = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)]
_Sizes = Field(min_length=1, max_length=1000)
_Shift = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]
Bearing = TypeAliasType("Bearing", Literal["thread", "jewel"])
"""How the rotor is held."""
Defect = TypeAliasType("Defect", Literal["stator_tilt", "rotor_tilt", "jewel_tilt", "lateral"])
"""Manufacturing defect (paper fig:diagram-manufacturing-defects-schematic)."""
JewelPivot = TypeAliasType("JewelPivot", Literal["contact", "rotor_centre", "stator_centre"])
"""About what a jewel is tilted."""
LateralDirection = TypeAliasType("LateralDirection", Literal["along", "across"])
"""Of a displacement, against the stator's magnetisation."""
# Told as a list of one, because generated clients take a constant for the whole of a union.
Infinite = TypeAliasType(
    "Infinite", Annotated[Literal["inf"], WithJsonSchema({"type": "string", "enum": ["inf"], "title": "Infinite"})]
)
"""What JSON has no number for."""
Ratio = float | Infinite
"""A length over the rotor's radius; "inf": a flat jewel, or a thread that does not tilt."""


class MagnetValues(Schema):
    """The two spheres."""

    radius_m: float
    """r of each sphere, m."""
    remanence_t: float
    """B_r, T."""
    density_kg_per_m3: float
    """rho, kg/m^3."""
    distance_m: float
    """d of their centres, m."""


class PrintedFriction(Schema):
    """Friction as the paper prints it, which does not follow from the mu that it prints."""

    friction_coefficient: float
    """mu as printed."""
    t_f_nm: float
    """T_f as printed, N m."""
    tf_over_i_rad_per_s2: float
    """T_f/I as printed, rad/s^2 (paper eq:TfoverI)."""
    follows_from_friction_coefficient: float
    """The mu with which the paper's equations give the printed T_f."""
    note: str
    """The same in words."""


class FrictionReport(Schema):
    """Dry friction of a jewel bearing by design."""

    cup_radius_over_r: float
    """R/r."""
    friction_coefficient: float
    """mu."""
    lambda_factor: float
    """Lambda(R/r): friction over that of a flat jewel."""
    contact_radius_m: float
    """a of the pressure circle, m (paper eq:a)."""
    t_f_nm: float
    """T_f without deflection, N m (paper eq:tf, eq:tf(phi))."""
    tf_over_i_rad_per_s2: float
    """T_f/I, rad/s^2."""
    quality_factor_per_rad: float | None
    """Quality factor over amplitude, 1/rad; the same at any size (paper sup:proof_size_independence); null: without
    friction."""
    printed: Absent[PrintedFriction] = None
    """At the paper's design point: what it prints; else missing."""


class MeasuredValues(Schema):
    """What was measured on the specimen and overrides its design; null: was not."""

    m_r_am2: float | None
    """m_r, A m^2."""
    f_nat_hz: float | None
    """f_nat, Hz."""
    tf_over_i_rad_per_s2: float | None
    """T_f/I, rad/s^2."""


class ProcedureStep(Schema):
    """A step of the paper's six."""

    step: int
    """From 1."""
    what: str
    """What is done."""
    source: str
    """Label in the paper."""
    values: dict[str, float | Vector]
    """What it brings, by name with unit; vectors are x, y, z, the axis of the bearing is z."""


class StaticProcedure(Schema):
    """From a manufacturing error to its perpendicular force in six steps, at one error and one deflection."""

    bearing: Bearing
    """Bearing."""
    defect: Defect
    """Defect."""
    span_over_r: Ratio
    """R/r of a cup, l/r of a thread."""
    eps_deg: float
    """Error angle, degrees."""
    phi_deg: float
    """Deflection, degrees."""
    f_perp_n: float
    """What comes out: equivalent perpendicular force, N."""
    steps: tuple[ProcedureStep, ...]
    """The six steps."""


class DesignReport(Schema):
    """What follows from magnets and bearing alone."""

    model_config = ConfigDict(json_schema_extra=example("design_report"))

    resonator: str
    """Its name in words."""
    magnets: MagnetValues
    """The magnets."""
    m_r_am2: float
    """Magnetic moment of the rotor, A m^2 (paper eq:m_r)."""
    inertia_kg_m2: float
    """Moment of inertia I of the rotor, kg m^2."""
    b_0_t: float
    """Field of the stator at the rotor, T (paper eq:T_m)."""
    f_nat_hz: float
    """Natural frequency, Hz (paper eq:fnat)."""
    f_m_n: float
    """Attraction of the magnets without deflection, N (paper eq:fm(phi))."""
    f_g_n: float
    """Weight of the rotor, N."""
    friction: FrictionReport | None
    """Of a jewel bearing; null: a thread."""
    measured: MeasuredValues | None
    """What was measured; null: the paper's design point."""
    procedures: tuple[StaticProcedure, ...]
    """The six steps for each bearing that it has."""


class DefectCase(Schema):
    """A defect of one size at one deflection."""

    eps_deg: Absent[float] = None
    """Error angle of a tilt, degrees; else missing."""
    dy_mm: Absent[float] = None
    """Size of a displacement, mm; else missing."""
    phi_deg: float
    """Deflection about the new axis, degrees."""
    f_perp_n: float
    """Equivalent perpendicular force, N."""
    dy_c_m: float
    """Distance of the rotor's centre at rest from the axis of the bearing, m."""
    alpha_rad: float
    """Angle between the new axis, towards the anchor, and the rotor's moment; pi/2 without defect."""


class DefectsReport(Schema):
    """Equivalent perpendicular force of a manufacturing defect (paper sec. ssec:manufacturing_errors_side_modes)."""

    model_config = ConfigDict(json_schema_extra=example("defects_report"))

    bearing: Bearing
    """Bearing."""
    defect: Defect
    """Defect."""
    cup_radius_over_r: Absent[Ratio] = None
    """R/r of a jewel bearing; else missing."""
    thread_length_over_r: Absent[Ratio] = None
    """l/r of a thread bearing; else missing."""
    pivot: Absent[JewelPivot] = None
    """About what the jewel is tilted; else missing."""
    direction: Absent[LateralDirection] = None
    """Of a displacement, against the stator's magnetisation; else missing."""
    cases: tuple[DefectCase, ...]
    """Every size at every deflection, sizes outside."""


MOST_CASES = 20_000


class DefectsRequest(Request):
    """A manufacturing defect in some sizes, at some deflections; at most 20 000 cases."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"bearing": "jewel", "defect": "stator_tilt", "eps_deg": [0.5, 2.0], "phi_deg": [30.0]},
                {"bearing": "thread", "defect": "lateral", "dy_mm": [0.1], "thread_length_over_r": "inf"},
            ]
        }
    )

    bearing: Bearing
    """How the rotor is held."""
    defect: Defect
    """stator_tilt, lateral; of a thread rotor_tilt, of a jewel jewel_tilt."""
    eps_deg: Annotated[list[_Quarter], _Sizes] | None = None
    """Error angles of a tilt, degrees; beyond 90 the magnet is the other way round."""
    dy_mm: Annotated[list[_Shift], _Sizes] | None = None
    """Sizes of a displacement, mm."""
    phi_deg: Annotated[list[_Quarter], _Sizes] = Field(default=[30.0])
    """Deflections about the new axis, degrees; beyond 90 the magnets repel each other."""
    cup_radius_over_r: Finite | Infinite | None = None
    """R/r of a jewel bearing, "inf": flat; null: the resonator's, else the paper's 5/3."""
    thread_length_over_r: Finite | Infinite | None = None
    """l/r of a thread bearing, "inf": it does not tilt; null: the resonator's, else the paper's 8."""
    pivot: JewelPivot | None = None
    """About what a jewel is tilted; null: the contact."""
    direction: LateralDirection | None = None
    """Of a displacement, against the stator's magnetisation; null: along."""
    resonator: ModelName | None = None
    """Name of a resonator, one of GET /resonators, of which the magnets are; null: the paper's design point."""

    @property
    def sizes(self) -> list[float]:
        """Degrees of a tilt, mm of a displacement."""
        return (self.dy_mm if self.defect == "lateral" else self.eps_deg) or []

    @model_validator(mode="after")
    def _bounded(self) -> DefectsRequest:
        if (cases := len(self.sizes) * len(self.phi_deg)) > MOST_CASES:
            raise ValueError(f"{cases} cases are more than {MOST_CASES}: ask for fewer sizes or deflections")
        return self
