"""One shot: the only code of the daemon that lets power out.

The order is the safety argument: the receiver is disconnected and read back before the amplifier is enabled; the card's
lines then keep gate and receiver apart sample-exactly (checked on the timeline before it is programmed); the amplifier
is disabled as soon as the host has the last TX sample; and every way out ends in `Platform.outputs_off`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.errors import DeviceError, DeviceFault, DeviceStateError, InterlockError, ShotRefused
from drivers.io_card import ChunkFlags
from drivers.platform import Platform
from drivers.thermometer import plausible_temperature_c
from drivers.timeline import DigitalLine, Timeline
from drivers.tx_rx_switch import SwitchPosition
from platform_daemon.core.jobs.jobs import Cancelled

from .input_range import ConverterRangeCheck

CHUNK_S = 0.1  # how often cancel is looked at and progress reported


@dataclass(frozen=True)
class RawShot:
    """What came back from the card.

    volts: (inputs, n) float32, V at the ADC input, n = all samples of the timeline unless the shot was refused early;
    temperature_c: deg C, None: nobody measures it, or its reading failed; reason: None for a good shot, else why it
    must not be used; warnings: what is not known of a shot that can be used.
    """

    volts: NDArray[np.float32]
    started: datetime
    started_monotonic_s: float
    temperature_c: float | None
    flags: ChunkFlags
    amplifier_clipped: bool
    lna_overloaded: bool
    reason: str | None = None
    warnings: tuple[str, ...] = ()
    truth: dict[str, object] = field(default_factory=dict)


class Playable(Protocol):
    """What can be played: a checked timeline; blank: no power is wanted, the amplifier stays disabled."""

    @property
    def timeline(self) -> Timeline:
        """What the card plays."""

    @property
    def blank(self) -> bool:
        """No power is wanted."""


def run_shot(
    platform: Platform,
    plan: Playable,
    *,
    cancelled: Callable[[], bool] = lambda: False,
    progress: Callable[[int], None] = lambda samples: None,
) -> RawShot:
    """Make one shot; outputs are off when it returns or raises.

    Every 0.1 s of samples `cancelled` is called and, once the amplifier is off, `progress(samples so far)`.  A shot
    whose samples are flagged or not contiguous comes back with a `reason`.  Raises Cancelled, InterlockError if the
    receiver cannot be confirmed disconnected, DeviceError if a device fails.
    """
    try:
        _prepare(platform, plan, cancelled)
        if cancelled():  # a stop after this line leaves the card idle, so that it will not trigger
            raise Cancelled
        started, monotonic = platform.clock.utc(), platform.clock.monotonic_s()
        platform.card.trigger()
        volts, flags, reason, clipped = _collect(platform, plan, cancelled, progress)
        doubt, overloaded = _devices_after(platform, plan.timeline)
        reason = reason or doubt
    except DeviceStateError:
        if cancelled():  # the caller that cancelled has stopped the card
            raise Cancelled from None
        raise
    finally:
        platform.outputs_off()
    temperature_c, warnings = _temperature_c(platform)
    return RawShot(
        volts=volts,
        started=started,
        started_monotonic_s=monotonic,
        temperature_c=temperature_c,
        flags=flags,
        amplifier_clipped=clipped,
        lna_overloaded=overloaded,
        reason=reason or _device_verdict(clipped, overloaded),
        warnings=warnings,
        truth=platform.ground_truth(),
    )


def _prepare(platform: Platform, plan: Playable, cancelled: Callable[[], bool]) -> None:
    """Receiver off and read back, timeline loaded, then the amplifier (its gate is still low).

    A stop that came meanwhile has reported all outputs off: raises Cancelled instead of enabling the amplifier again.
    """
    if not _is_on_transmit(platform):
        platform.switch.to_transmit()
        if not _is_on_transmit(platform):
            raise InterlockError(
                "the receiver is not confirmed disconnected, so the amplifier stays off",
                where="tx_rx_switch",
                remedy="check the switch and its read-back",
            )
    platform.lna.clear_overload()
    platform.card.program(plan.timeline)
    platform.card.arm()
    if not plan.blank:
        for step in (platform.guard.power_may_come, platform.amplifier.enable, platform.amplifier.unmute):
            if cancelled():
                raise Cancelled
            step()


def _is_on_transmit(platform: Platform) -> bool:
    return platform.switch.position() is SwitchPosition.TRANSMIT


def _collect(
    platform: Platform,
    plan: Playable,
    cancelled: Callable[[], bool],
    progress: Callable[[int], None],
) -> tuple[NDArray[np.float32], ChunkFlags, str | None, bool]:
    """All samples of the timeline; the amplifier is disabled once TX is over."""
    timeline = plan.timeline
    volts = np.empty((platform.card.capabilities().inputs, timeline.total_samples), dtype=np.float32)
    step = max(1, round(CHUNK_S * timeline.clock.rate_hz))
    watch = ConverterRangeCheck(platform.card.capabilities())
    done, flags, clipped, powered = 0, ChunkFlags(), False, not plan.blank
    doubt: str | None = None
    while done < timeline.total_samples:
        if cancelled():
            raise Cancelled
        platform.guard.alive()
        try:
            piece = platform.card.read(_wanted(done, step, timeline))
            _check_contiguous(piece.first_sample, piece.volts.shape, volts.shape, done)
        except ShotRefused as refusal:
            if powered:  # a gate on a DIO pin may still be high, and other devices are queried before all is off
                platform.amplifier.disable()
            return volts[:, :done], flags, str(refusal), clipped
        volts[:, done : done + piece.volts.shape[1]] = piece.volts
        watch.see(piece.volts[:, max(timeline.rx_start - done, 0) :])
        done += piece.volts.shape[1]
        flags = flags | piece.flags
        if powered and done >= timeline.tx_samples:
            clipped, powered = _end_of_power(platform), False
        if done == timeline.rx_start + 1 < timeline.total_samples:
            doubt = _receiver_missing(platform, timeline)
        if not powered:  # the callback may wait for a disk
            progress(done)
    flagged = f"the I/O card flagged the samples: {', '.join(flags.names())}" if flags.names() else None
    return volts, flags, flagged or doubt or watch.verdict(), clipped


def _wanted(done: int, step: int, timeline: Timeline) -> int:
    """Samples to read next: chunks end with TX, when power must go off, and with the first RX sample."""
    ends = (timeline.tx_samples, timeline.rx_start + 1, timeline.total_samples)
    return min(step, next(end for end in ends if end > done) - done)


def _receiver_missing(platform: Platform, timeline: Timeline) -> str | None:
    """Why the RX window would be silence taken for data, None if the switch followed its line.

    The position is the present one: read after the window, which by the card's clock ends with the timeline, it proves
    nothing.  Raises DeviceFault if the switch rests elsewhere in the middle of the window.
    """
    position, sample = platform.switch.position(), platform.card.sample()
    if sample is None or sample >= timeline.total_samples:
        return "the host was too late to see the receiver connected"
    if position is SwitchPosition.MOVING:
        return "the contacts of the switch still moved in the RX window"
    if position is not SwitchPosition.RECEIVE:
        raise DeviceFault(
            f"the switch is on {position} in the RX window",
            where="tx_rx_switch",
            why="it did not follow its line",
            remedy="check the switch and its line",
        )
    return None


def _late_contacts(platform: Platform, timeline: Timeline) -> str | None:
    """Why the start of the RX window is no data, None if the contacts had settled in time or this was not measured."""
    took_s = platform.switch.last_move_s(SwitchPosition.RECEIVE)
    rises = [e.start_sample for e in timeline.lines if e.line is DigitalLine.RX_CONNECT]
    if took_s is None or not rises:
        return None
    allowed_s = (timeline.rx_start - rises[-1] + 1) / timeline.clock.rate_hz - platform.switch.timing().settle_s
    if took_s <= allowed_s:
        return None
    return (
        f"the switch needed {1e3 * took_s:.3g} ms to come to rest on the receiver, {1e3 * allowed_s:.3g} ms are allowed"
    )


def _devices_after(platform: Platform, timeline: Timeline) -> tuple[str | None, bool]:
    """Why the shot is no data by what the devices say after it, None if they do not; whether the LNA was overloaded.

    A device that does not answer now makes the shot doubtful and does not take its samples away.
    """
    try:
        return _late_contacts(platform, timeline), platform.lna.overloaded()
    except DeviceStateError:
        raise
    except DeviceError as error:
        return f"it is not known whether the receiver was disturbed: {error}", False


def _temperature_c(platform: Platform) -> tuple[float | None, tuple[str, ...]]:
    """The temperature of the resonator, and why it is not known."""
    if platform.thermometer is None:
        return None, ()
    try:
        return plausible_temperature_c(platform.thermometer), ()
    except Exception as error:  # whatever a driver raises: the samples are there
        return None, (f"the temperature is not known: {error}",)


def _check_contiguous(first: int, shape: tuple[int, ...], wanted: tuple[int, ...], done: int) -> None:
    """The card's own count must continue where the last chunk ended."""
    if shape[0] != wanted[0] or shape[1] < 1 or first + shape[1] > wanted[1]:
        raise ShotRefused(f"a chunk of shape {shape} at sample {first} does not fit a shot of shape {wanted}")
    if first != done:
        raise ShotRefused(f"samples {done} to {first} are missing" if first > done else f"sample {first} came twice")


def _end_of_power(platform: Platform) -> bool:
    """Disable the amplifier after TX; returns whether it clipped, raises DeviceFault if it tripped during TX."""
    status = platform.amplifier.status_after_tx()
    platform.amplifier.disable()
    if status.fault is not None:
        raise DeviceFault(
            f"the amplifier tripped during the shot: {status.fault}",
            where="power_amplifier",
            remedy="find the cause, then reset the fault",
        )
    return status.clipped


def _device_verdict(clipped: bool, overloaded: bool) -> str | None:
    if clipped:
        return "the power amplifier clipped, so the excitation is not the requested one"
    if overloaded:
        return "the low-noise amplifier was overloaded"
    return None
