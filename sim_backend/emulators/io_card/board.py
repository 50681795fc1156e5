"""One I/O card behind its server: modes, registers, trigger, write pointer, recorded samples.

Methods that change something are called with the world's lock held (`scpi_session` takes it); times are samples since
this card's trigger.
"""

from __future__ import annotations

import math
from dataclasses import replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from sim_backend.world.faults import DROPPED

from .memory import CLEAR_ACCESSES
from .options import AXES, BoardOptions
from .registers import BASE_HZ, PINS, Registers
from .sample_ring import RING
from .sequence import Sequence, State
from .shot import Lab, Shot

BURST = 32  # the RAM writer's granularity, sample pairs
HALF_SCALE = 32768  # ADC codes
FLAG_BITS = {"overwritten": 1, "corrupted": 2}


class Mode(Enum):
    """Server modes."""

    CONFIGURATION = "CONFIGURATION"
    ACQUISITION = "ACQUISITION"
    TRANSMISSION = "TRANSMISSION"


class Board:
    """State that survives a reconnect, and what the converters see."""

    def __init__(self, cards: Lab, options: BoardOptions) -> None:
        self.cards = cards
        self.options = options
        self.mode = Mode.CONFIGURATION
        self.decimation = 16
        self.fir = True
        self.trigger_mode = "INTERNAL"
        self.propagate = False
        self.keep_alive = False
        self.trigger_on = False
        self.registers = Registers()
        self.sequence = Sequence()
        self.history: list[tuple[int, Registers]] = []
        self.triggered = False
        self.offset = 0
        self.pin_out: dict[str, bool] = {}
        self.pin_on: dict[str, bool] = {}
        self.pin_bridge: dict[str, bool] = {}
        self.words = {"watchdog": "OFF", "instant_reset": "OFF", "source_type": "DIO", "source": "DIO7_P"}
        self.numbers = {"presamples": 0, "reference": 0}
        self.counter_clocks = 0
        self.counter_trigger = {"enabled": False, "armed": False, "reset": False}
        self.emergency_pressed = False  # the level of the emergency input DIO3_P
        self.emergency_latched = False  # it was high with the trigger on; all outputs are zero until the trigger falls
        scales = {"ADC": options.adc_scale_v, "DAC": options.dac_scale}
        self.scales = {(kind, k): float(np.float32(scale[k])) for kind, scale in scales.items() for k in (0, 1)}
        self.offsets = {("ADC", k): options.adc_offset_v[k] for k in (0, 1)} | {("DAC", k): 0.0 for k in (0, 1)}
        self.limits = {(k, side): level for k in (0, 1) for side, level in (("LOWER", -1.0), ("UPPER", 1.0))}
        self.calibration_flags = options.calibration_flags
        self.flags = 0
        self._shot: Shot | None = None
        self._before: Shot | None = None
        self._shot_offset = self._before_offset = 0
        self._frozen = 0
        self._fault_at = math.inf
        self._cleared_s = -math.inf

    def power_up(self, options: BoardOptions) -> None:
        """The server has been restarted with these options: the card's image is loaded, and all registers are reset."""
        with self.cards.world.lock:
            self.trigger_on = self.keep_alive = False
            self.cards.update_trigger()
            shots = self._shot, self._shot_offset
            self.__init__(self.cards, options)  # type: ignore[misc]
            self._before, self._before_offset = shots  # its RAM keeps what was recorded
            self.cards.changed()

    # --- time

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return BASE_HZ / self.decimation

    def filter_delay(self) -> float:
        """How many samples a signal appears late in the recording."""
        return filter_delay(self.decimation, fir=self.fir)

    def elapsed(self) -> float:
        """Samples since the trigger; 0 without one."""
        return self._shot.now() - self.offset if self.triggered and self._shot is not None else 0.0

    def write_pointer(self) -> int:
        """What the card has written since its trigger, in its steps."""
        if not self.triggered:
            return self._frozen if self.keep_alive else 0
        taken = self.elapsed()
        faults = self.faults()
        if "card_timeout" in faults:
            taken = min(taken, self._fault_at)
        if "dropped_samples" in faults and taken > self._fault_at:
            taken = max(taken - DROPPED, self._fault_at)
        return int(max(taken, 0.0)) // BURST * BURST

    def reached_s(self, pointer: int) -> float:
        """World time at which the write pointer gets there."""
        assert self._shot is not None
        steps = math.ceil(pointer / BURST) * BURST + self.offset
        return self._shot.start_s + (steps + 1e-3) / self._shot.clock.rate_hz

    # --- trigger

    def held_back(self) -> bool:
        """True if an enabled counter trigger that is not armed keeps the trigger from coming."""
        return self.counter_trigger["enabled"] and not self.counter_trigger["armed"]

    def trigger_rose(self, offset: int) -> None:
        """The trigger comes; `offset` in samples of the common shot."""
        self.triggered = True
        self.offset = offset
        self._fault_at = math.inf
        self.sequence.started()
        self.registers = replace(self.registers, program=self.sequence.program, muted=False)
        quiet = [(0, Registers(muted=True, pins=self.registers.pins))] if offset else []
        self.history = [*quiet, (offset, self.registers)]
        self.check_emergency()

    def joined(self, shot: Shot) -> None:
        """The shot that the trigger began or joined."""
        self._before = self._shot
        self._before_offset = self._shot_offset
        self._shot = shot
        self._shot_offset = self.offset

    def trigger_fell(self) -> None:
        """The trigger goes: the sequence is over, the pointer cleared or frozen."""
        self.settle()
        self._frozen = self.write_pointer()
        if self.sequence.state is State.RUNNING:
            self.sequence.aborted()
            self._cleared_s = self.cards.world.clock.monotonic_s() + self.clear_s()
            self.registers = self.registers.silenced()
        self.triggered = False
        self.emergency_latched = False
        self._record(replace(self.registers, muted=True, program=None))

    def settle(self) -> None:
        """If the sequence has ended by now: the server has stopped everything (stopTx)."""
        program = self.registers.program
        held = self.emergency_latched  # the emergency input holds the stepper: the sequence seems to run for ever
        if self.triggered and not held and program is not None and self.write_pointer() >= program.stop:
            self._cleared_s = self.reached_s(int(program.stop)) + self.clear_s()
            self.sequence.finished()
            self.registers = self.registers.silenced()
            self._record(self.registers, at=int(program.stop) + self.offset)
        if self.sequence.state is State.CLEARING and self.cards.world.clock.monotonic_s() >= self._cleared_s:
            self.sequence.cleared()

    def clear_s(self) -> float:
        """How long the server takes to empty its memory."""
        return CLEAR_ACCESSES * self.options.memory_access_s

    def sequence_stop(self) -> float:
        """Sample after the trigger at which the running sequence ends; 0: there is none, inf: it never does."""
        return 0.0 if self.registers.program is None else self.registers.program.stop

    # --- registers

    def write(self, registers: Registers) -> None:
        """New registers, from now on."""
        self.registers = registers
        self._record(replace(registers, muted=registers.muted or not self.triggered))
        self.cards.changed()

    def stop_tx(self, *, offsets: bool = False) -> None:
        """All waveforms, tables and the sequence to zero; offsets only on request."""
        self.settle()
        self.sequence.emptied()
        registers = self.registers.silenced()
        if offsets:
            registers = replace(registers, outputs=tuple(replace(o, offset_v=0.0) for o in registers.outputs))
        self.write(registers)

    def client_changed(self) -> None:
        """A client came or went."""
        self.stop_tx()
        self.sequence.forgotten()
        if self.mode is Mode.TRANSMISSION:
            self.mode = Mode.ACQUISITION

    def set_pins(self) -> None:
        """The pins' levels from directions and values; a pin that carries a waveform's pulses has none of its own."""
        own = {p for p in PINS if self.pin_out.get(p, True) and not self.pin_bridge.get(p, False)}
        on = frozenset(p for p, value in self.pin_on.items() if value and p in own)
        self.write(replace(self.registers, pins=on))

    # --- the emergency input

    def instant_reset(self, level: bool) -> None:
        """The level that the pin DIO3_P gets from outside."""
        self.emergency_pressed = level
        self.check_emergency()

    def check_emergency(self) -> None:
        """The emergency input, its mode or the trigger may have changed: latch the input if all three are on."""
        if self.triggered and self.words["instant_reset"] == "ON" and self.emergency_pressed:
            self.emergency_latched = True
            self.write(replace(self.registers, muted=True))

    def _record(self, registers: Registers, at: int | None = None) -> None:
        if not self.history or self._shot is None or self._shot.over:
            return
        now = math.ceil(self._shot.now()) if at is None else at
        self.history.append((max(now, self.history[-1][0]), registers))

    # --- status and samples

    def faults(self) -> frozenset[str]:
        """World faults of the present shot that this card shows."""
        return self.cards.world.faults.at(self.cards.world.shots) if self.triggered else frozenset()

    def status(self) -> int:
        """The status byte."""
        lost = self.sequence.lost_steps
        return self.flags | lost << 2 | self.triggered << 3 | self.sequence.busy << 4

    def reading(self, start: int, count: int) -> None:
        """A client asks for samples: faults strike in the middle of them."""
        if self._shot is not None and self.triggered:
            self._shot.wanted = max(self._shot.wanted, start + count + self.offset)
            self.cards.world.shot_simulator.replan()
            if math.isinf(self._fault_at):
                self._fault_at = start + count // 2

    def strike(self, first: int, stop: int) -> None:
        """Set the flags of a chunk first..stop that the server begins to send."""
        self.flags = 0
        if first <= self._fault_at < stop:
            faults = self.faults()
            self.flags = sum(bit for name, bit in FLAG_BITS.items() if name in faults)
            self.sequence.lost_steps |= "lost_steps" in faults
        if self.write_pointer() - first > RING:
            self.flags |= FLAG_BITS["overwritten"]

    def samples(self, first: int, stop: int) -> bytes:
        """What the RAM holds for first..stop: int16 pairs; not yet written samples are those of the shot before."""
        written = self.write_pointer() if self.triggered else stop
        known = min(max(written, first), stop)
        new = self._codes(self._shot, self._shot_offset, first, known)
        old = self._codes(self._before, self._before_offset, known, stop)
        return np.concatenate([new, old]).astype("<i2").tobytes()

    def _codes(self, shot: Shot | None, offset: int, first: int, stop: int) -> NDArray[np.float64]:
        """(n, 2) ADC codes."""
        if shot is None or first >= stop:
            return np.zeros((stop - first, 2))
        skipped = DROPPED if "dropped_samples" in self.faults() and first >= self._fault_at else 0
        volts = shot.volts(first + offset + skipped, stop + offset + skipped)
        return adc_codes(volts, self.options, adc_gain(self.decimation, fir=self.fir))


def filter_delay(decimation: int, *, fir: bool) -> float:
    """How many samples a signal appears late in the recording."""
    cic = ((decimation / 2 if fir else decimation) - 1) / 2 * 6 / decimation
    return cic + (92 - 1) / 2 / 2 if fir else cic


def adc_gain(decimation: int, *, fir: bool) -> float:
    """Gain of the first decimation filter, which nothing takes off; 1 for powers of two."""
    rate = decimation / 2 if fir else decimation
    return float(rate**6 / 2 ** math.ceil(6 * math.log2(rate)))


def adc_codes(volts: NDArray[np.float32], options: BoardOptions, gain: float) -> NDArray[np.float64]:
    """(n, 2) codes of the volts (3, n) of the three axes; 0 at an input that nothing is connected to."""
    codes = np.zeros((volts.shape[1], 2))
    for column, axis in enumerate(options.inputs):
        if axis:
            u = volts[AXES.index(axis)].astype(np.float64)
            u = (u - options.adc_offset_v[column]) / options.adc_scale_v[column]
            codes[:, column] = np.rint(np.clip(u, -HALF_SCALE, HALF_SCALE - 1) * gain)
    return codes
