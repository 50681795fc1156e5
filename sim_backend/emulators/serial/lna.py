"""The serial controller of the low-noise amplifier (docs/reference/wiring.md)."""

from __future__ import annotations

from sim_backend.world.world import World

from .serial_port import BAD_ARGUMENT, FAULT, NOT_NOW, UNKNOWN


class LnaController:
    """One gain for all channels, and an overload latch."""

    def __init__(self, world: World, serial: str) -> None:
        self._world = world
        self._serial = serial

    def execute(self, line: str) -> str:
        """See SerialDevice."""
        match line.split():
            case ["*IDN?"]:
                return f"Simulated,LNA 3x,{self._serial},1.0"
            case ["GAINS?"]:
                return ",".join(f"{g:g}" for g in self._world.options.lna.gains)
            case ["GAIN?"]:
                return FAULT if self._broken() else f"{self._world.lna_gain:g}"
            case ["GAIN", text]:
                return self._set_gain(text)
            case ["GAIN", *_]:
                return BAD_ARGUMENT
            case ["OVL?"]:
                self._world.refresh()
                return str(int(self._world.lna_overloaded))
            case ["OVL:CLR"]:
                self._world.refresh()
                with self._world.lock:
                    self._world.lna_overloaded = self._world.lna_broken
                return "OK"
        return UNKNOWN

    def _set_gain(self, text: str) -> str:
        try:
            gain = float(text)
        except ValueError:
            return BAD_ARGUMENT
        if gain not in self._world.options.lna.gains:
            return BAD_ARGUMENT
        if self._broken():
            return FAULT
        if self._world.is_running():
            return NOT_NOW
        self._world.lna_gain = gain
        return "OK"

    def _broken(self) -> bool:
        self._world.refresh()
        return self._world.lna_broken
