"""The class-D amplifier's SCPI interpreter; what carries the texts is `usbtmc`."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from sim_backend.transmit.power import OVER_CURRENT, OVER_TEMPERATURE
from sim_backend.world.world import World

from ..scpi import CommandTable, split

IDENTITY = "Simulated,class-D amplifier 3x,{serial},1.0"
FAULT_NUMBERS = {OVER_TEMPERATURE: 1, OVER_CURRENT: 2}
QUEUE = 16

Answer = str | None


class Refused(Exception):
    """A command that goes into the error queue."""


class AmplifierScpi:
    """`execute` takes one line and gives the answer, None if the line asks for none.  One caller at a time."""

    def __init__(self, world: World, serial: str) -> None:
        self._world = world
        self._serial = serial
        self._errors: deque[str] = deque(maxlen=QUEUE)
        self._table: CommandTable[Callable[[list[str]], Answer]] = CommandTable(
            {
                "*IDN?": lambda _: IDENTITY.format(serial=self._serial),
                "*CLS": lambda _: self._errors.clear(),
                "*RST": lambda _: self.off(),
                "*OPC?": lambda _: "1",
                "SYSTem:ERRor?": lambda _: self._errors.popleft() if self._errors else '0,"No error"',
                "OUTPut": self._output,
                "OUTPut?": lambda _: str(int(self._world.power.enabled)),
                "OUTPut:MUTE": self._mute,
                "OUTPut:MUTE?": lambda _: str(int(self._world.power.muted)),
                "SYSTem:TEMPerature?": lambda _: f"{self._world.amplifier_temperature_c():.2f}",
                "STATus:FAULt?": lambda _: self._fault(),
                "STATus:FAULt:RESet": lambda _: self._reset(),
                "STATus:CLIP?": lambda _: str(int(self._world.power.clipped)),
            }
        )

    def execute(self, line: str) -> Answer:
        """Answers of all commands in a line, joined by `;`; None if there is nothing to say."""
        answers = [self._one(c) for c in line.split(";") if c.strip()]
        said = [a for a in answers if a is not None]
        return ";".join(said) if said else None

    def off(self) -> None:
        """As after power-on."""
        self._world.amplifier(enabled=False, muted=True)

    def _one(self, command: str) -> Answer:
        header, arguments = split(command)
        found = self._table.find(header)
        if found is None:
            self._errors.append('-113,"Undefined header"')
            return None
        self._world.refresh()
        try:
            return found[0](arguments)
        except Refused as error:
            self._errors.append(str(error))
            return None

    def _output(self, arguments: list[str]) -> None:
        if not _switch(arguments):
            self.off()
            return
        with self._world.lock:
            power = self._world.power
            if power.fault is not None:
                raise Refused('-200,"fault latched"')
            if not power.enabled:
                power.clipped = False
            self._world.amplifier(enabled=True)

    def _mute(self, arguments: list[str]) -> None:
        muted = _switch(arguments)
        if not muted and not self._world.power.enabled:
            raise Refused('-221,"Settings conflict"')
        self._world.amplifier(muted=muted)

    def _fault(self) -> str:
        fault = self._world.power.fault
        return '0,"none"' if fault is None else f'{FAULT_NUMBERS.get(fault, 99)},"{fault}"'

    def _reset(self) -> None:
        self._world.reset_amplifier()


def _switch(arguments: list[str]) -> bool:
    levels = {"ON": True, "1": True, "OFF": False, "0": False}
    if len(arguments) != 1 or arguments[0].upper() not in levels:
        raise Refused('-224,"Illegal parameter value"')
    return levels[arguments[0].upper()]
