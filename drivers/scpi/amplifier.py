"""A class-D power amplifier that speaks SCPI."""

from __future__ import annotations

import math
from dataclasses import replace

from drivers.errors import DeviceFault, DeviceProtocolError, DeviceStateError, DeviceTimeout
from drivers.exchange import Exchange
from drivers.identity import Identity
from drivers.power_amplifier import AmplifierStatus, PowerAmplifier
from drivers.scpi.dialogue import fault_of, number, numbered, yes
from drivers.scpi.options import AmplifierCommands, Words

_HOTTEST_C = 300.0
"""Numbers beyond it stand for a sensor that is missing: 9.9E37 is the NaN of SCPI."""


class ScpiAmplifier(PowerAmplifier):
    """See drivers.power_amplifier.PowerAmplifier.

    One without mute commands is muted by disabling it: its power stage is then on only while it is unmuted.
    """

    def __init__(self, exchange: Exchange, commands: AmplifierCommands, words: Words) -> None:
        self._exchange = exchange
        self._do = commands
        self._words = words
        self._enabled_muted = False  # of an amplifier without mute commands
        exchange.on_open = self._make_safe
        exchange.last_words = tuple(filter(None, (commands.disable, commands.mute)))
        self._make_safe(exchange)
        self.disable()

    def identity(self) -> Identity:
        """See PowerAmplifier."""
        return self._exchange.identity()

    def status(self) -> AmplifierStatus:
        """See PowerAmplifier.  Temperature, fault and clipping are absent where the device does not report them."""
        return replace(self.status_after_tx(), temperature_c=self._temperature_c())

    def status_after_tx(self) -> AmplifierStatus:
        """See PowerAmplifier."""
        live = self._is_on()
        return AmplifierStatus(
            enabled=live or self._enabled_muted,
            muted=yes(self._exchange, self._do.muted, self._words) if self._do.muted else not live,
            fault=self._fault(),
            temperature_c=None,
            clipped=bool(self._do.clipped) and yes(self._exchange, self._do.clipped, self._words),
        )

    def _temperature_c(self) -> float | None:
        """Its temperature, which decides nothing: None also for an answer that is none, or none in time."""
        if not self._do.temperature:
            return None
        try:
            reading = number(self._exchange, self._do.temperature)
        except (DeviceProtocolError, DeviceTimeout):
            return None
        return reading if math.isfinite(reading) and abs(reading) < _HOTTEST_C else None

    def enable(self) -> None:
        """See PowerAmplifier.  Raises DeviceFault also if the device refuses or does not read back so."""
        fault = self._fault()
        if fault is not None:
            raise DeviceFault(f"fault latched: {fault}", where=self._exchange.where, remedy="reset the fault first")
        if not self._do.mute:
            self._enabled_muted = True
            return
        if not self._is_on():
            self._command(self._do.mute)
        self._command(self._do.enable)
        self._confirm(on=True)

    def disable(self) -> None:
        """See PowerAmplifier.  Raises DeviceFault if it reads back enabled, twice.

        A shot that is stopped as it begins may enable it between the command and the question.
        """
        self._tell_off()
        if self._is_on():
            self._tell_off()
            self._confirm(on=False)

    def mute(self) -> None:
        """See PowerAmplifier."""
        self._exchange.tell(self._do.mute or self._do.disable)

    def unmute(self) -> None:
        """See PowerAmplifier."""
        if not (self._enabled_muted or self._is_on()):
            raise DeviceStateError("the amplifier is disabled", where=self._exchange.where, remedy="enable it first")
        self._command(self._do.unmute or self._do.enable)
        self._confirm(on=True)

    def reset_fault(self) -> None:
        """See PowerAmplifier.  It is switched off first, because it may resume as soon as its fault is cleared."""
        self.disable()
        if self._do.reset_fault:
            self._command(self._do.reset_fault)
            self.disable()
        fault = self._fault()
        if fault is not None:
            raise DeviceFault(f"the fault stays: {fault}", where=self._exchange.where, **self._what_to_do())

    def close(self) -> None:
        """See PowerAmplifier."""
        try:
            self.disable()
        finally:
            self._exchange.close()

    def _what_to_do(self) -> dict[str, str]:
        """Why a fault stays, and the remedy."""
        if self._do.reset_fault:
            return {"remedy": "remove its cause, let the amplifier cool down, then reset again"}
        why = "power_amplifier.commands.reset_fault is empty: this model has no such command"
        return {"why": why, "remedy": "switch its mains off and on"}

    def _make_safe(self, exchange: Exchange) -> None:
        """After every opening: no old errors, and off, whatever it was before."""
        if self._do.clear:
            exchange.tell(self._do.clear)
        self._tell_off(exchange)

    def _tell_off(self, exchange: Exchange | None = None) -> None:
        self._enabled_muted = False
        exchange = exchange or self._exchange
        exchange.tell(self._do.disable)
        if self._do.mute:
            exchange.tell(self._do.mute)

    def _is_on(self) -> bool:
        return yes(self._exchange, self._do.enabled, self._words)

    def _fault(self) -> str | None:
        return fault_of(self._exchange, self._do.fault, self._words) if self._do.fault else None

    def _command(self, text: str) -> None:
        """Send it, and see whether the device put an error into its queue."""
        self._exchange.tell(text)
        complaint = numbered(self._exchange, self._do.error) if self._do.error else None
        if complaint is not None:
            raise DeviceFault(
                f"the amplifier refused {text!r}", where=self._exchange.where, why=complaint, remedy="see its manual"
            )

    def _confirm(self, *, on: bool) -> None:
        if self._is_on() is not on:
            raise DeviceFault(
                f"the amplifier reads back {'off' if on else 'on'} after it was switched {'on' if on else 'off'}",
                where=self._exchange.where,
                remedy="switch its mains off by hand" if not on else "check it",
            )
