"""Tables of single devices in a platform file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from drivers.specimen import Position
from sim_backend.section import Count, Finite, NonNegative, Positive, Section

Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]


class IoCardTable(Section):
    """`[io_card]`.

    base_frequency_hz, decimation: converter clock, Hz, over its decimation is the sampling rate; max_samples: longest
    timeline; step_samples: grid of the edges, 1: every sample; output_step_v: step of the amplitudes, V, 0: continuous.
    A real card's sequence and registers have such steps.
    """

    base_frequency_hz: Positive
    decimation: Count
    max_samples: Count
    step_samples: Count = 1
    output_step_v: NonNegative = 0.0


class LnaTable(Section):
    """`[lna]`: initial gain, V/V."""

    gain: Positive


class CalibrationTable(Section):
    """`[calibration]`.

    lna_gain: LNA gain for which the calibration holds, V/V; position_m: where it was made, m; frequency_max_hz: highest
    frequency, Hz; gain_error: deliberate relative error of each channel, 0: exact.
    """

    lna_gain: Positive
    position_m: Position
    frequency_max_hz: Positive
    identifier: Annotated[str, Field(min_length=1)]
    date: Annotated[str, Field(min_length=10)]
    gain_error: Vector = (0.0, 0.0, 0.0)


class StandardTable(Section):
    """`[reference_dipole] standard`, a generator that may feed the coil.

    frequency_hz, relative_std, source: as reported to the daemon; amplitude_v: of its tone; clock_error: by how much
    the card's clock is too fast, relative, as the standard shows it, which the daemon does not know.
    """

    frequency_hz: Positive
    relative_std: Annotated[float, Field(gt=0, lt=1)]
    source: Annotated[str, Field(min_length=1)] = "the frequency standard"
    amplitude_v: Positive = 0.5
    clock_error: Annotated[float, Field(gt=-0.01, lt=0.01)] = 0.0


class DipoleTable(Section):
    """`[reference_dipole]`, a small coil.

    output: output of the card that feeds it, to which no Helmholtz pair is connected; turns_area_m2: turns times area,
    m^2; resistance_ohm, inductance_h: of its loop; relative_std: uncertainty of the moment, direction_std_rad: of
    its direction about each of the axes across, rad, both as reported to the daemon; position_m: where it is, m;
    tilt_rad: how it is turned about x, y, z wherever it is put, rad, which the daemon does not know.
    """

    output: Annotated[int, Field(ge=3, le=3)]
    turns_area_m2: Positive
    resistance_ohm: Positive
    inductance_h: NonNegative
    relative_std: Annotated[float, Field(ge=0, lt=1)]
    direction_std_rad: Annotated[float, Field(gt=0, lt=1)] | None = None
    position_m: Position = (0.0, 0.0, 0.0)
    tilt_rad: Vector = (0.0, 0.0, 0.0)
    standard: StandardTable | None = None


class ProbeTable(Section):
    """`[field_probe]`.

    noise_t: rms noise per sample, T; relative_std: uncertainty of the sensitivity, as reported to the daemon;
    position_m: where it is, m.
    """

    noise_t: NonNegative
    relative_std: Annotated[float, Field(ge=0, lt=1)]
    position_m: Position = (0.0, 0.0, 0.0)


class EmptyTable(Section):
    """A device table without keys of its own."""
