"""The safety envelope: limits of the site that every sequence must keep, checked before the hardware acts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from drivers.errors import SequenceRejected
from drivers.io_card import CardCapabilities
from drivers.timeline import DigitalLine, Timeline
from drivers.tx_rx_switch import SwitchTiming
from sequences.drive import ChannelDrive
from sequences.figures import ShotFigures

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class SafetyLimits(BaseModel):
    """Table `[limits]` of a platform file.

    max_field_t: field amplitude at the rotor, T; max_coil_current_a: per coil, A; max_tx_s: length of the TX window, s;
    max_tx_duty: share of a shot that may be TX; settle_warning: share of the deflection that may remain at the next
    shot before a warning is given; max_coil_i2t_a2s: integral of the squared current over a shot, per coil, A^2 s;
    max_coil_heat_w: heat in a coil, averaged over a shot, W; None: not limited; min_guard_s: least time from the end of
    the amplifier's gate to the receiver's connection, s; max_lease_s: longest lease of the guard, s; None: not limited.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    max_field_t: Positive
    max_coil_current_a: Positive
    max_tx_s: Positive
    max_tx_duty: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)]
    max_coil_i2t_a2s: Positive | None = None
    max_coil_heat_w: Positive | None = None
    settle_warning: Annotated[float, Field(gt=0, lt=1, allow_inf_nan=False)] = 0.03
    min_guard_s: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    max_lease_s: Positive | None = None


def check_drive(field_t: float, drives: Sequence[ChannelDrive], limits: SafetyLimits) -> None:
    """Check field, coil current and amplifier voltage; raise SequenceRejected with limit and remedy."""
    _at_most("the field amplitude", field_t, limits.max_field_t, "T", "limits.max_field_t", "field_t")
    for d in drives:
        name = f"the current of coil {d.channel.axis}"
        _at_most(name, abs(d.current_a), limits.max_coil_current_a, "A", "limits.max_coil_current_a", "field_t")
        name = f"the amplifier voltage of coil {d.channel.axis}"
        _at_most(name, d.amplifier_v, d.channel.amplifier_limit_v, "V", "the amplifier's limit", "field_t")


ROUNDING = 1e-3  # error of `figures_of`; the amplitude of one steady sine is checked exactly by `check_drive`


def check_figures(
    figures: ShotFigures, drives: Sequence[ChannelDrive], duration_s: float, limits: SafetyLimits
) -> None:
    """Check the load of the exact samples against the limits; raise SequenceRejected like `check_drive`.

    A loop that is not driven by one steady sine may exceed the amplitudes of its drive.
    """
    field_t = figures.peak_field_t / (1 + ROUNDING)
    _at_most("the peak of the field", field_t, limits.max_field_t, "T", "limits.max_field_t", "field_t")
    voltages = {d.channel.axis: d.channel.amplifier_limit_v for d in drives}
    for coil in figures.coils:
        name = f"of coil {coil.axis}"
        peak_a, peak_v = coil.peak_a / (1 + ROUNDING), coil.peak_v / (1 + ROUNDING)
        limit_a, limit_v = limits.max_coil_current_a, voltages[coil.axis]
        _at_most(f"the peak current {name}", peak_a, limit_a, "A", "limits.max_coil_current_a", "field_t")
        _at_most(f"the peak voltage {name}", peak_v, limit_v, "V", "the amplifier's limit", "field_t")
        if limits.max_coil_i2t_a2s is not None:
            most, source = limits.max_coil_i2t_a2s, "limits.max_coil_i2t_a2s"
            _at_most(f"I2t {name}", coil.i2t_a2s, most, "A^2 s", source, "field_t")
        if limits.max_coil_heat_w is not None:
            mean_w, most, source = coil.heat_j / duration_s, limits.max_coil_heat_w, "limits.max_coil_heat_w"
            change = "lengthen sequence.rx_s, or lower sequence.field_t"
            _at_most(f"the heat {name}", mean_w, most, "W", source, "field_t", change)


def check_timeline(
    timeline: Timeline,
    limits: SafetyLimits,
    card: CardCapabilities,
    switch: SwitchTiming,
    amplifier_off_s: float = 0.0,
) -> None:
    """Check times, DAC range and the exclusion of power and receiver; raise SequenceRejected.

    amplifier_off_s: how long the amplifier may put out power after its gate has fallen.

    The check uses only the finished timeline and not the way it was made, so that it detects a mistake of the compiler.
    """
    rate = timeline.clock.rate_hz
    tx_s = timeline.tx_samples / rate
    _at_most("the TX window", tx_s, limits.max_tx_s, "s", "limits.max_tx_s", "tx_periods")
    duty = timeline.tx_samples / timeline.total_samples
    enough_s = tx_s / limits.max_tx_duty - (tx_s + timeline.switch_samples / rate)
    change = f"lengthen sequence.rx_s to {max(enough_s, 0.0):.3g} s or more, or lower sequence.tx_periods"
    _at_most("the share of TX in the shot", duty, limits.max_tx_duty, "", "limits.max_tx_duty", "tx_periods", change)
    total = timeline.total_samples
    _at_most("the length of the shot", total, card.max_samples, "samples", "the card's memory", "rx_s")
    for output in {b.output for b in timeline.bursts}:
        peak = float(np.max(np.abs(timeline.output_volts(output, 0, timeline.tx_samples))))
        name = f"DAC output {output}"
        _at_most(name, peak, card.output_full_scale_v, "V", "the card's output range", "field_t")
    _check_exclusion(timeline, switch, card.line_delay_s * rate, max(limits.min_guard_s, amplifier_off_s) * rate)


def _check_exclusion(timeline: Timeline, switch: SwitchTiming, late: float, guard: float) -> None:
    """Check that power and receiver are never on together, and that the receiver has settled before RX begins.

    late: possible delay of the lines, samples; guard: time that the amplifier needs to switch off, samples.
    """
    power = [level for level in timeline.lines if level.line is DigitalLine.PA_GATE]
    receive = [level for level in timeline.lines if level.line is DigitalLine.RX_CONNECT]
    for p in power:
        for r in receive:
            apart = late + guard
            if r.start_sample <= p.stop_sample + apart and p.start_sample <= r.stop_sample + late:
                raise SequenceRejected(
                    "the receiver would be connected while the amplifier can put out power",
                    where=f"samples {max(p.start_sample, r.start_sample)} to {min(p.stop_sample, r.stop_sample)}",
                    why=f"of {r.start_sample - p.stop_sample} samples between the two lines, {late:.0f} are the lines' "
                    f"delay and {guard:.0f} the least guard (limits.min_guard_s, power_amplifier.turn_off_s)",
                    remedy=f"set sequence.guard_samples to {math.floor(apart) + 1} or more",
                )
    for b in timeline.bursts:
        if not all(timeline.is_high(DigitalLine.PA_GATE, k) for k in (b.start_sample, b.stop_sample - 1)):
            raise SequenceRejected("a burst lies outside the amplifier's gate", where=f"output {b.output}")
    settled = [r.start_sample + late + switch.total_s * timeline.clock.rate_hz for r in receive]
    if not receive or min(settled) > timeline.rx_start:
        rate = timeline.clock.rate_hz
        have = (timeline.rx_start - receive[0].start_sample) / rate if receive else 0.0
        raise SequenceRejected(
            f"the receiver is connected {have * 1e3:.2f} ms before RX begins",
            where="sequence.switch_s",
            why=f"the switch needs {switch.total_s * 1e3:.2f} ms until receive data are good",
            remedy="make the switch window longer or the guard shorter",
        )


def _at_most(what: str, value: float, limit: float, unit: str, source: str, key: str, change: str = "") -> None:
    change = change or f"lower sequence.{key}"
    if not value <= limit:
        raise SequenceRejected(
            f"{what} would be {value:.4g} {unit}".rstrip(),
            where=f"sequence.{key}",
            why=f"{source} is {limit:.4g} {unit}".rstrip(),
            remedy=f"{change}, or have the limit changed by the person responsible for the platform",
        )
