"""A door into the emulated world for tests: JSON lines over TCP, {"do": NAME, ...} -> {"ok": true, "result": ...}.

truth, violations, outputs, clock, power_log  what only the world knows
inject {kind, shot}                           a world fault (sim_backend/world/faults.py); shot absent: the next one
wire_fault {kind, device, ...}                a fault of the wire (wire_faults.py), from now on
trip_amplifier                                latches a fault of the amplifier now
clear_faults, repair                          forget faults to come; replace what broke as well
mount {specimen}, hold_still                  another resonator (its TOML tables); stop it with a finger
turn_dipole {axis}                            the reference dipole along an axis in the resonator's place; null: out
instant_reset {board, level}                  the card's emergency input
trigger_cable {joined}                        the cable that brings the master's trigger to the other cards
"""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict
from typing import Annotated, Any

from pydantic import Field

from drivers.errors import InputError, PlatformError
from drivers.specimen import Specimen
from drivers.validation import validated
from sim_backend.devices.reference import SimulatedReferenceDipole
from sim_backend.section import Section

from .io_card.options import OUTPUTS
from .io_card.playback import high_spans, output_bursts
from .io_card.session import Cards
from .wire_faults import WireFault, WireFaults

Action = Callable[[Mapping[str, Any]], Any]


class _WorldFault(Section):
    """A fault of the world; shot: its number from 1, None: the next one."""

    kind: str
    shot: Annotated[int, Field(ge=1)] | None = None


class Control:
    """Executes the requests of the control socket."""

    def __init__(
        self, cards: Cards, faults: Mapping[str, WireFaults], dipole: SimulatedReferenceDipole | None = None
    ) -> None:
        self._cards = cards
        self._world = cards.world
        self._faults = faults
        self._dipole = dipole
        self._actions: dict[str, Action] = {
            "truth": lambda _: self._world.truth(),
            "violations": lambda _: [v.as_dict() for v in self._world.violations()],
            "power_log": lambda _: [asdict(span) for span in self._world.power_log()],
            "outputs": lambda _: self.outputs(),
            "clock": lambda _: {"world_s": self._world.clock.monotonic_s(), "shots": self._world.shots},
            "inject": self._inject,
            "wire_fault": self._wire_fault,
            "trip_amplifier": lambda _: self._world.trip_amplifier(),
            "clear_faults": lambda _: self._clear(),
            "repair": lambda _: self._repair(),
            "mount": self._mount,
            "turn_dipole": self._turn_dipole,
            "hold_still": lambda _: self._hold_still(),
            "instant_reset": self._instant_reset,
            "trigger_cable": lambda request: self._cards.join_cable(bool(request["joined"])),
        }

    def serve(self, link: socket.socket) -> None:
        """One connection."""
        with suppress(OSError), link.makefile("rwb") as stream:
            for line in stream:
                stream.write(json.dumps(self.reply(line)).encode() + b"\n")
                stream.flush()

    def reply(self, line: bytes) -> dict[str, Any]:
        """The answer to one request."""
        try:
            request = json.loads(line)
            action = self._actions[request.pop("do")]
            return {"ok": True, "result": action(request)}
        except PlatformError as error:
            return {"ok": False, "error": str(error)}
        except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
            return {"ok": False, "error": f"no such request: {error!r}"}

    def outputs(self) -> dict[str, Any]:
        """What the outputs do now; `off`: no DAC plays, the gate is low, and the amplifier puts out nothing."""
        world = self._world
        world.refresh()
        position = world.contacts().position(world.clock.monotonic_s())
        with world.lock:
            playing = [p for board in self._cards.boards for p in self._playing(board)]
            gate = self._gate()
            power = world.power
            live = power.enabled and not power.muted and power.fault is None
        return {
            "playing": playing,
            "pa_gate": gate,
            "amplifier_live": live,
            "receiver": position.value,
            "off": not playing and not (gate and live),
        }

    def _playing(self, board: Any) -> list[str]:
        board.settle()
        if self._cards.shot is None or not board.history:
            return []
        now = int(self._cards.shot.now())
        rate = self._cards.shot.clock.rate_hz
        return [
            axis
            for k, axis in enumerate(board.options.outputs)
            if axis and output_bursts(board.history, k, OUTPUTS.index(axis), now, now + 1, rate)
        ]

    def _gate(self) -> bool:
        line = self._cards.options.pa_gate
        board = self._cards.boards[line.board]
        if self._cards.shot is None or not board.history:
            return line.pin() in board.registers.pins
        board.settle()
        now = int(self._cards.shot.now())
        return bool(high_spans(board.history, line.pin(), line.pdm(), now, now + 1))

    def _inject(self, request: Mapping[str, Any]) -> int:
        fault = validated(_WorldFault, request, "inject")
        shot = self._world.shots + 1 if fault.shot is None else fault.shot
        self._world.faults.inject(fault.kind, shot)
        return shot

    def _wire_fault(self, request: Mapping[str, Any]) -> None:
        fault = validated(WireFault, request, "wire_fault")
        arm(self._faults, fault)

    def _clear(self) -> None:
        self._world.faults.clear()
        for each in self._faults.values():
            each.clear()

    def _repair(self) -> None:
        self._clear()
        self._world.repair()

    def _hold_still(self) -> None:
        self._check_idle()
        self._world.hold_still()

    def _check_idle(self) -> None:
        if self._world.is_running():
            raise InputError("a shot is running", where="control", remedy="end it first")

    def _mount(self, request: Mapping[str, Any]) -> None:
        self._check_idle()
        self._world.mount(validated(Specimen, request["specimen"], "specimen"))

    def _turn_dipole(self, request: Mapping[str, Any]) -> None:
        """Along an axis in the resonator's place; axis null: out again."""
        self._check_idle()
        if self._dipole is None:
            raise InputError("there is no reference dipole", where="control", remedy="add [reference_dipole]")
        if request["axis"] is None:
            self._dipole.remove()
        else:
            self._dipole.turn(request["axis"])

    def _instant_reset(self, request: Mapping[str, Any]) -> None:
        with self._world.lock:
            self._cards.boards[request.get("board", 0)].instant_reset(bool(request["level"]))


def arm(faults: Mapping[str, WireFaults], fault: WireFault) -> None:
    """Let a fault strike.  Raises InputError if there is no such device."""
    if fault.device not in faults:
        raise InputError(f"no device is called {fault.device!r}", remedy=f"use one of {', '.join(sorted(faults))}")
    faults[fault.device].arm(fault)
