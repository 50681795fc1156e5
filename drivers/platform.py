"""A platform: the four devices, the coils' transmit side, the calibration, and the clock they live by."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

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
    back end need offer only the devices it has; the others raise DeviceNotFound.
    """

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
        """The operator has put this resonator into the clamping unit.  Real back ends: nothing to do.

        One that does it by itself has an attribute `changes_resonators` that is true.
        """

    def warm_up(self) -> object:
        """Do now what would make the first shot late (compiling, loading); blocking, harmless to repeat."""

    def ground_truth(self) -> Mapping[str, Any] | None:
        """What only a simulation knows of the shot just made (seed, effects, parameters); None on real hardware."""


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
        """Tell every back end which resonator is in the clamping unit."""
        for backend in self.backends.values():
            backend.mount(specimen)

    @property
    def changes_resonators(self) -> bool:
        """It mounts what is asked for; else the operator does."""
        return any(getattr(backend, "changes_resonators", False) for backend in self.backends.values())

    def warm_up(self) -> None:
        """Let every back end do what takes long the first time."""
        for backend in self.backends.values():
            backend.warm_up()

    def ground_truth(self) -> dict[str, Any]:
        """What simulated back ends know of the last shot, by back end; empty on real hardware."""
        records = {name: backend.ground_truth() for name, backend in self.backends.items()}
        return {name: dict(record) for name, record in records.items() if record is not None}

    def outputs_off(self) -> None:
        """Card stopped, amplifier disabled, receiver disconnected, all at once, so that none waits for another that
        does not answer; one OutputsUnconfirmed lists all that failed.  Any thread, any time.

        A switch or amplifier on the card's lines, and a switch that a timeline still moves, comes after the card.
        """
        self.guard.switching_off()
        card = Step(self.card.stop)
        amplifier = Step(self.amplifier.disable, after=card if _on_card(self.amplifier) else None)
        switch = Step(self.switch.to_transmit, after=card)
        refuse_failures([each.failure() for each in (card, amplifier, switch)])
        self.guard.power_is_off()

    def close(self) -> None:
        """Outputs off and every device let go, the card last: others may hang on its lines; one DeviceError lists
        all that failed."""
        devices = (self.amplifier, self.switch, self.lna, self.thermometer, self.card)
        steps = [self.outputs_off, *(d.close for d in devices if d is not None)]
        _raise_all("the platform did not close cleanly", [_failure(step) for step in steps], DeviceError)
        self.guard.close()  # one that did not close stays guarded until this process has ended


def refuse_failures(failures: list[str]) -> None:
    """Raises OutputsUnconfirmed for those that are not empty."""
    _raise_all("outputs could not be confirmed off", failures, OutputsUnconfirmed)


class Step:
    """Something done in a thread of its own, when another step is over or has had its time."""

    def __init__(self, step: Callable[[], None], after: Step | None = None) -> None:
        self._step, self._after, self._failed = step, after, ""
        self.over = threading.Event()
        threading.Thread(target=self._run, name="outputs-off", daemon=True).start()

    def failure(self) -> str:
        """Wait for it, and for what it waits for, OFF_S each; what failed, "" if nothing did."""
        if not self.over.wait(OFF_S if self._after is None else 2 * OFF_S):
            return f"{getattr(self._step, '__qualname__', self._step)}: not over after {OFF_S:g} s"
        return self._failed

    def _run(self) -> None:
        if self._after is not None:
            self._after.over.wait(OFF_S)
        self._failed = _failure(self._step)
        self.over.set()


def _on_card(device: object) -> bool:
    """True for a device that has no wire but the card's lines."""
    return bool(getattr(device, "on_card_lines", False))


def _failure(step: Callable[[], None]) -> str:
    """Do it; what failed, "" if nothing did."""
    try:
        step()
    except Exception as error:  # every later step must still be tried
        return f"{getattr(step, '__qualname__', step)}: {error}"
    return ""


def _raise_all(what: str, failures: list[str], kind: type[DeviceError]) -> None:
    failed = [each for each in failures if each]
    if failed:
        raise kind(what, why="; ".join(failed), remedy="switch the amplifier's mains off by hand")
