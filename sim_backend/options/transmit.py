"""The transmit side: amplifier, coils and how they are wired."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from sim_backend.section import Count, Finite, NonNegative, Positive, Section

Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]
Output = Annotated[int, Field(ge=0, le=2)]


class AmplifierOptions(Section):
    """The class-D amplifier and its heat sink.

    gain: voltage gain, V/V; limit_v: output limit, V; output_impedance_ohm: output impedance, ohm.  The power idle_w
    (while enabled) and the share loss_fraction of the delivered energy heat a heat sink of heat_capacity_j_per_k, which
    cools through the thermal resistance cooling_k_per_w; above trip_temperature_c the amplifier trips.
    """

    gain: Positive
    limit_v: Positive
    output_impedance_ohm: NonNegative
    idle_w: NonNegative
    loss_fraction: NonNegative
    heat_capacity_j_per_k: Positive
    cooling_k_per_w: Positive
    trip_temperature_c: Finite


class CoilOptions(Section):
    """One Helmholtz pair.

    radius_m: of each loop, m; turns: per loop; separation_m: distance of the loops, m; resistance_ohm, inductance_h: of
    both loops in series; offset_m: displacement of the pair, m; axis_error_rad: tilt of the pair, a small Rodrigues
    vector, rad.
    """

    radius_m: Positive
    turns: Count
    separation_m: Positive
    resistance_ohm: Positive
    inductance_h: Positive
    offset_m: Vector = (0.0, 0.0, 0.0)
    axis_error_rad: Vector = (0.0, 0.0, 0.0)


class CoilsOptions(Section):
    """The three pairs, named by their axis in world coordinates."""

    x: CoilOptions
    y: CoilOptions
    z: CoilOptions

    def in_order(self) -> tuple[CoilOptions, CoilOptions, CoilOptions]:
        """x, y, z."""
        return self.x, self.y, self.z


class WiringOptions(Section):
    """How the amplifier is wired; the defaults are the correct wiring.

    outputs: DAC output (0, 1, 2) that drives the coils x, y, z; factors: factor on the voltage of each coil, -1:
    reversed, 0.5: half the gain, 0: open cable.
    """

    outputs: Annotated[tuple[Output, Output, Output], Field(strict=False)] = (0, 1, 2)
    factors: Vector = (1.0, 1.0, 1.0)
