"""Tables of single devices: what a platform file says of each one that the simulated world offers."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from drivers.specimen import Position
from sim_backend.section import Count, Finite, NonNegative, Positive, Section

Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]


class IoCardTable(Section):
    """`[io_card]`: converter clock Hz, decimation, longest timeline in samples; grid of the edges in samples and step
    of the amplitudes in V (a real card's sequence and registers have steps; 1 and 0: any)."""

    base_frequency_hz: Positive
    decimation: Count
    max_samples: Count
    step_samples: Count = 1
    output_step_v: NonNegative = 0.0


class LnaTable(Section):
    """`[lna]`: gain V/V set at the start."""

    gain: Positive


class CalibrationTable(Section):
    """`[calibration]`: LNA gain V/V it holds for, position m it was made at, highest frequency Hz, name and date; and
    deliberate errors of the calibration, relative per channel (0: exact)."""

    lna_gain: Positive
    position_m: Position
    frequency_max_hz: Positive
    identifier: Annotated[str, Field(min_length=1)]
    date: Annotated[str, Field(min_length=10)]
    gain_error: Vector = (0.0, 0.0, 0.0)


class DipoleTable(Section):
    """`[reference_dipole]`: turns times area A m^2/A and position m of a small coil; resistance ohm and inductance H of
    its loop, fed by the card's `output`, which no coil hangs on; relative_std: of the moment, as told to the daemon.
    """

    output: Annotated[int, Field(ge=3, le=3)]
    turns_area_m2: Positive
    resistance_ohm: Positive
    inductance_h: NonNegative
    relative_std: Annotated[float, Field(ge=0, lt=1)]
    position_m: Position = (0.0, 0.0, 0.0)


class ProbeTable(Section):
    """`[field_probe]`: noise T rms per sample, position m; relative_std: of its sensitivity, as told to the daemon."""

    noise_t: NonNegative
    relative_std: Annotated[float, Field(ge=0, lt=1)]
    position_m: Position = (0.0, 0.0, 0.0)


class EmptyTable(Section):
    """A device table without keys of its own."""
