"""The transmit side: amplifier, coils and how they are wired."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from sim_backend.section import Count, Finite, NonNegative, Positive, Section

Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]
Output = Annotated[int, Field(ge=0, le=2)]


class AmplifierOptions(Section):
    """Class-D amplifier: voltage gain V/V, output limit V, output impedance ohm, and its heat sink.

    idle_w (while enabled) and loss_fraction of the delivered energy heat a body of heat_capacity_j_per_k that cools
    through cooling_k_per_w; above trip_temperature_c it trips.
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
    """One Helmholtz pair: loop radius m, turns per loop, distance of the loops m, resistance ohm and inductance H of
    both in series; offset_m moves the pair, axis_error_rad (small Rodrigues vector) tilts it."""

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
    """How the amplifier is wired, from x, y, z as they should be: the DAC output (0, 1, 2) that each coil hangs on, and
    a factor on each coil's voltage (-1: turned round, 0.5: half the gain, 0: cable open)."""

    outputs: Annotated[tuple[Output, Output, Output], Field(strict=False)] = (0, 1, 2)
    factors: Vector = (1.0, 1.0, 1.0)
