"""The back end `red_pitaya`: the I/O card, and the switch and amplifier that hang on its lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivers.backend import RealBackend
from drivers.card_lines.amplifier import PlainAmplifier
from drivers.card_lines.switch import LineSwitch
from drivers.errors import ConfigError
from drivers.red_pitaya.card import RedPitayaCard
from drivers.red_pitaya.options import AmplifierTable, LineTable, Section, SwitchTable, card_table, check_pin
from drivers.tx_rx_switch import SwitchTiming
from drivers.validation import validated


class RedPitayaBackend(RealBackend):
    """See drivers.platform.Backend; the table `[backends.red_pitaya]` is empty."""

    name = "red_pitaya"

    def __init__(self, options: Mapping[str, Any]) -> None:
        validated(Section, options, "backends.red_pitaya")
        self._card: RedPitayaCard | None = None

    def io_card(self, options: Mapping[str, Any]) -> RedPitayaCard:
        """See Backend."""
        self._card = RedPitayaCard(card_table(options))
        return self._card

    def tx_rx_switch(self, options: Mapping[str, Any]) -> LineSwitch:
        """See Backend.  Driven by the card's line RX_CONNECT."""
        table = validated(SwitchTable, options, "tx_rx_switch")
        card = self._opened("tx_rx_switch")
        readback = self._digital(table.readback, "tx_rx_switch.readback")
        if readback is not None:
            card.use_pin(*readback, output=False)
        timing = SwitchTiming(dead_time_s=table.dead_time_s, bounce_s=table.bounce_s, settle_s=table.settle_s)
        return LineSwitch(card, timing, readback)

    def power_amplifier(self, options: Mapping[str, Any]) -> PlainAmplifier:
        """See Backend.  Enabled by a DIO pin."""
        table = validated(AmplifierTable, options, "power_amplifier")
        card = self._opened("power_amplifier")
        enable = self._digital(table.enable, "power_amplifier.enable")
        fault = self._digital(table.fault, "power_amplifier.fault")
        assert enable is not None
        card.use_pin(*enable, output=True)
        if fault is not None:
            card.use_pin(*fault, output=False)
        return PlainAmplifier(card, enable, fault)

    def _opened(self, device: str) -> RedPitayaCard:
        if self._card is None:
            raise ConfigError(
                "this device hangs on the I/O card", where=device, remedy="set io_card.backend = 'red_pitaya', too"
            )
        return self._card

    def _digital(self, table: LineTable | None, where: str) -> tuple[int, str] | None:
        if table is None:
            return None
        check_pin(table.board, table.pin, len(self._opened(where).boards), where, digital=True)
        return table.board, table.pin
