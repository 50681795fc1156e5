"""A platform: the four devices, the coils' transmit side, the calibration, and the clock they live by."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

from drivers.calibration import ReceiveCalibration, TransmitCalibration, TransmitChannel
from drivers.clock import Clock
from drivers.errors import DeviceError, OutputsUnconfirmed
from drivers.io_card import IoCard
from drivers.lna import Lna
from drivers.power_amplifier import PowerAmplifier
from drivers.power_guard import NoGuard, PowerGuard
from drivers.reference import FieldProbe, ReferenceDipole
from drivers.specimen import Specimen
from drivers.thermometer import Thermometer
from drivers.tx_rx_switch import TxRxSwitch

OFF_S = 10.0  # for one device to confirm that its output is off, new connections included


class Backend(Protocol):
    """What a back end offers.  It is built once per platform, so its devices can share a connection or a world.

    Constructed as `Backend(options)` with the TOML table `[backends.NAME]`; each device method gets the device's own
    table without its `backend` key.  Both raise ConfigError for a key that is missing, unknown or out of range.  A
    back end need offer only the devices it has; the others raise DeviceNotFound.  Derive from
    `drivers.backend.RealBackend`, which has every default.

    in_process: the devices live in this process and end with it, so that no output can outlive it and no guard has to
    watch; changes_resonators: `mount` puts the resonator into the clamping unit by itself, else the operator does.
    """

    in_process: ClassVar[bool] = False
    changes_resonators: ClassVar[bool] = False

    def io_card(self, options: Mapping[str, Any]) -> IoCard:
        """The I/O card."""

    def tx_rx_switch(self, options: Mapping[str, Any]) -> TxRxSwitch:
        """The Tx/Rx switch."""

    def power_amplifier(self, options: Mapping[str, Any]) -> PowerAmplifier:
        """The power amplifier."""

    def lna(self, options: Mapping[str, Any]) -> Lna:
        """The low-noise amplifier."""

    def thermometer(self, options: Mapping[str, Any]) -> Thermometer:
        """The temperature sensor."""

    def transmit_channels(self, options: Mapping[str, Any]) -> tuple[TransmitChannel, ...]:
        """The coils seen from the DAC, in the order x, y, z."""

    def receive_calibration(self, options: Mapping[str, Any]) -> ReceiveCalibration:
        """The calibration of the receive side."""

    def reference_dipole(self, options: Mapping[str, Any]) -> ReferenceDipole:
        """The dipole that calibrates the receive side."""

    def field_probe(self, options: Mapping[str, Any]) -> FieldProbe:
        """The probe that calibrates the transmit side."""

    def clock(self) -> Clock:
        """The clock of this back end; real devices return SystemClock()."""

    def mount(self, specimen: Specimen) -> None:
        """The operator has put this resonator into the clamping unit.  Real back ends: nothing to do."""

    def warm_up(self) -> object:
        """Do in advance what would delay the first shot (compiling, loading).  Blocking; idempotent."""

    def ground_truth(self) -> Mapping[str, Any] | None:
        """What only a simulation knows of the last shot (seed, effects, parameters); None on real hardware."""


@dataclass
class Platform:
    """Everything needed to make a shot.  Built by `drivers.registry.build_platform`."""

    name: str
    card: IoCard
    switch: TxRxSwitch
    amplifier: PowerAmplifier
    lna: Lna
    thermometer: Thermometer | None
    transmit: tuple[TransmitChannel, ...]
    calibration: ReceiveCalibration
    clock: Clock
    backends: Mapping[str, Backend]
    reference: ReferenceDipole | None = None
    probe: FieldProbe | None = None
    transmit_calibration: TransmitCalibration | None = None
    amplifier_off_s: float = 0.0
    guard: PowerGuard = field(default_factory=NoGuard)

    def mount(self, specimen: Specimen) -> None:
        """Announce to every back end which resonator is in the clamping unit."""
        for backend in self.backends.values():
            backend.mount(specimen)

    @property
    def changes_resonators(self) -> bool:
        """A back end mounts the resonator of a request by itself; otherwise the operator does."""
        return any(backend.changes_resonators for backend in self.backends.values())

    def warm_up(self) -> None:
        """Warm up every back end."""
        for backend in self.backends.values():
            backend.warm_up()

    def ground_truth(self) -> dict[str, Any]:
        """What simulated back ends know of the last shot, by back end; empty on real hardware."""
        records = {name: backend.ground_truth() for name, backend in self.backends.items()}
        return {name: dict(record) for name, record in records.items() if record is not None}

    def outputs_off(self) -> None:
        """Stop the card, disable the amplifier and disconnect the receiver, all at once, so that none waits for another
        that does not answer.  Raises one OutputsUnconfirmed that lists all that failed.  Any thread, any time.

        A switch or amplifier on the card's lines, and a switch that a timeline still moves, comes after the card.
        """
        self.guard.switching_off()
        card = Step(self.card.stop)
        amplifier = Step(self.amplifier.disable, after=card if self.amplifier.on_card_lines else None)
        switch = Step(self.switch.to_transmit, after=card)
        refuse_failures([each.failure() for each in (card, amplifier, switch)])
        self.guard.power_is_off()

    def close(self) -> None:
        """Switch outputs off and close every device, the card last, because others may be driven by its lines.  Raises
        one DeviceError that lists all that failed."""
        devices = (self.amplifier, self.switch, self.lna, self.thermometer, self.card)
        steps = [self.outputs_off, *(d.close for d in devices if d is not None)]
        _raise_all("the platform did not close cleanly", [_failure(step) for step in steps], DeviceError)
        self.guard.close()  # one that did not close stays guarded until this process has ended


def refuse_failures(failures: list[str]) -> None:
    """Raises OutputsUnconfirmed for those that are not empty."""
    _raise_all("outputs could not be confirmed off", failures, OutputsUnconfirmed)


class Step:
    """An action in a thread of its own, begun when another step has ended or has timed out."""

    def __init__(self, step: Callable[[], None], after: Step | None = None) -> None:
        self._step = step
        self._after = after
        self._failed = ""
        self.over = threading.Event()
        threading.Thread(target=self._run, name="outputs-off", daemon=True).start()

    def failure(self) -> str:
        """Wait for this step and for the one before it, OFF_S each.  Returns what failed, "" if nothing did."""
        if not self.over.wait(OFF_S if self._after is None else 2 * OFF_S):
            return f"{getattr(self._step, '__qualname__', self._step)}: not over after {OFF_S:g} s"
        return self._failed

    def _run(self) -> None:
        if self._after is not None:
            self._after.over.wait(OFF_S)
        self._failed = _failure(self._step)
        self.over.set()


def _failure(step: Callable[[], None]) -> str:
    """Run the step.  Returns what failed, "" if nothing did."""
    try:
        step()
    except Exception as error:  # every later step must still be tried
        return f"{getattr(step, '__qualname__', step)}: {error}"
    return ""


def _raise_all(what: str, failures: list[str], kind: type[DeviceError]) -> None:
    failed = [each for each in failures if each]
    if failed:
        raise kind(what, why="; ".join(failed), remedy="switch the amplifier's mains off by hand")
