"""The wirings of gate and receiver that a platform may have, as overrides of the emulated lab and of its platform."""

from __future__ import annotations

from dataclasses import dataclass

from tests.kit.emulated_lab import lines_at


@dataclass(frozen=True)
class Wiring:
    """emulator, platform: overrides; chunk: samples per record of the stream; over_s: how much longer than the TX
    window power may reach the coils, whatever the wires do; follows_host: and as long as the host stands still.
    """

    name: str
    emulator: tuple[str, ...]
    platform: tuple[str, ...]
    chunk: int
    over_s: float
    follows_host: bool


def _by_sequence(name: str, gate: str, receiver: str) -> Wiring:
    """The gate closes by itself, to the sample."""
    return Wiring(name, *lines_at(gate, receiver), chunk=608, over_s=1e-3, follows_host=False)


def _by_host(name: str, gate: str, receiver: str) -> Wiring:
    """A gate stays high until a command lowers it: the card gets it from the host, which notices within `pin_delay_s` +
    0.25 s that nothing comes, or the amplifier, which it then switches off on its own wire."""
    return Wiring(name, *lines_at(gate, receiver), chunk=320, over_s=1.0, follows_host=True)


WIRINGS = (
    _by_sequence("sequence, one card", "0 AO0", "0 AO1"),
    _by_sequence("sequence, two cards", "0 AO0", "1 AO0"),
    _by_host("host, one card", "0 DIO7_P", "0 DIO6_P"),
    _by_host("host, two cards", "0 DIO7_P", "1 DIO6_P"),
)
