"""How well the influences on a result are known: `[uncertainty]` of a platform's or a resonator's file."""

from __future__ import annotations

import datetime as dt
import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
_WIDTH = {"rectangular": math.sqrt(3.0), "triangular": math.sqrt(6.0), "arcsine": math.sqrt(2.0)}


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Certificate(_Section):
    """A calibration certificate."""

    number: str = Field(min_length=1, description="Its number.")
    date: Annotated[dt.date, Field(strict=False)] = Field(description="When it was issued, ISO 8601.")
    valid_until: Annotated[dt.date, Field(strict=False)] | None = Field(
        default=None, description="Last day of its validity, ISO 8601; null: it says none."
    )

    @model_validator(mode="after")
    def _dates_in_order(self) -> Certificate:
        if self.valid_until is not None and self.valid_until < self.date:
            raise ValueError("valid_until is before date: a certificate is issued before it expires")
        return self


class Influence(_Section):
    """How well an influence is known: `u`, or `half_width` of a distribution with ends."""

    u: Positive | None = Field(
        default=None, description="Standard uncertainty, in the unit of the key; null: see half_width."
    )
    half_width: Positive | None = Field(
        default=None, description="It lies within this, in the unit of the key; null: see u."
    )
    distribution: Literal["normal", "rectangular", "triangular", "arcsine"] = Field(
        default="normal", description="Of what it may be; one with a half_width is no normal one."
    )
    dof: Annotated[float, Field(ge=1, allow_inf_nan=False)] | None = Field(
        default=None, description="Degrees of freedom of u; null: it is known exactly."
    )
    kind: Literal["A", "B"] = Field(default="B", description="A: from repeated observations; B: from anything else.")
    source: str = Field(default="", description="Where it is known from, in words.")
    certificate: Certificate | None = Field(default=None, description="Certificate that says so; null: there is none.")

    @model_validator(mode="after")
    def _one_width(self) -> Influence:
        if (self.u is None) == (self.half_width is None):
            raise ValueError("give either u or half_width")
        if self.half_width is not None and self.distribution == "normal":
            raise ValueError("a normal distribution has no half_width: give u, or distribution = 'rectangular'")
        return self

    @property
    def standard_uncertainty(self) -> float:
        """u, or what the half-width and the distribution make it (JCGM 100:2008, 4.3.7, 4.3.9)."""
        if self.u is not None:
            return self.u
        assert self.half_width is not None
        return self.half_width / _WIDTH[self.distribution]


class Correlation(_Section):
    """Two inputs of the budgets that err together."""

    between: Annotated[tuple[str, str], Field(strict=False)] = Field(
        description="Names of both, as budgets print them: 'gain of channel x'."
    )
    r: Annotated[float, Field(ge=-1, le=1)] = Field(description="Correlation coefficient, 1.")


class DeclaredUncertainty(_Section):
    """`[uncertainty]`; what is left out is not declared, and every budget says so."""

    sample_clock: Influence | None = Field(default=None, description="Frequency of the card's clock, relative, 1.")
    reference_dipole: Influence | None = Field(
        default=None,
        description="Moment and geometry of the dipole that P was measured with, relative, 1; it replaces what the "
        "calibration's file says.",
    )
    calibration_drift_per_year: Influence | None = Field(
        default=None, description="Relative change of P since it was measured, 1/a."
    )
    gain: Influence | None = Field(default=None, description="Gain of each receive channel since then, relative, 1.")
    phase_rad: Influence | None = Field(default=None, description="Phase of each receive channel at f_nat, rad.")
    orthogonality_rad: Influence | None = Field(
        default=None, description="Angle by which each coil is turned towards each of the others, rad."
    )
    thermometer_k: Influence | None = Field(
        default=None, description="Temperature of the resonator against what the thermometer says, K."
    )
    static_field_t: Influence | None = Field(
        default=None, description="Static field along the resting rotor, of unknown sign, T."
    )
    position_m: Influence | None = Field(default=None, description="Position of the rotor along x, y and z, each, m.")
    pose_rad: Influence | None = Field(
        default=None, description="How it is turned in the clamp, about x, y and z, each, rad."
    )
    coil_radius_m: Annotated[tuple[Positive, Positive, Positive], Field(strict=False)] | None = Field(
        default=None, description="Radii of the Helmholtz pairs x, y, z, m: what a position does to P; null: not said."
    )
    temperature_coefficient_per_k: dict[str, Finite] = Field(
        default_factory=dict, description="Change of parameters with temperature, by public name, their unit per K."
    )
    correlation: Annotated[tuple[Correlation, ...], Field(strict=False)] = Field(
        default=(), description="Inputs that err together."
    )

    @model_validator(mode="after")
    def _one_coefficient_a_pair(self) -> DeclaredUncertainty:
        told: dict[frozenset[str], float] = {}
        for each in self.correlation:
            one, other = each.between
            if one == other:
                raise ValueError(f"correlation is declared of {one!r} with itself: name two inputs")
            if (before := told.setdefault(frozenset(each.between), each.r)) != each.r:
                raise ValueError(
                    f"correlation of {one!r} and {other!r} is declared twice, as {before:g} and {each.r:g}"
                )
        return self

    def under(self, own: DeclaredUncertainty | None) -> DeclaredUncertainty:
        """These declarations, with those of something more particular in the place of the same ones."""
        if own is None:
            return self
        given = {name: getattr(own, name) for name in own.model_fields_set}
        given["temperature_coefficient_per_k"] = {
            **self.temperature_coefficient_per_k,
            **own.temperature_coefficient_per_k,
        }
        pairs = {frozenset(each.between) for each in own.correlation}
        kept = (each for each in self.correlation if frozenset(each.between) not in pairs)
        given["correlation"] = (*kept, *own.correlation)
        return self.model_copy(update=given)
