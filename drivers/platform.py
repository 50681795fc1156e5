"""A platform: the four devices, the coils' transmit side, the calibration, and the clock they live by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from drivers.calibration import ReceiveCalibration, TransmitCalibration, TransmitChannel
from drivers.clock import Clock
from drivers.errors import DeviceError, OutputsUnconfirmed
from drivers.io_card import IoCard
from drivers.lna import Lna
from drivers.power_amplifier import PowerAmplifier
from drivers.reference import FieldProbe, ReferenceDipole
from drivers.specimen import Specimen
from drivers.thermometer import Thermometer
from drivers.tx_rx_switch import TxRxSwitch


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
        """The operator has put this resonator into the clamping unit.  Real back ends: nothing to do."""

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

    def mount(self, specimen: Specimen) -> None:
        """Tell every back end which resonator is in the clamping unit."""
        for backend in self.backends.values():
            backend.mount(specimen)

    def warm_up(self) -> None:
        """Let every back end do what takes long the first time."""
        for backend in self.backends.values():
            backend.warm_up()

    def ground_truth(self) -> dict[str, Any]:
        """What simulated back ends know of the last shot, by back end; empty on real hardware."""
        records = {name: backend.ground_truth() for name, backend in self.backends.items()}
        return {name: dict(record) for name, record in records.items() if record is not None}

    def outputs_off(self) -> None:
        """Card stopped, amplifier disabled, receiver disconnected, in this order; every step is tried even if another
        fails, then one OutputsUnconfirmed lists all that failed.  Any thread, any time."""
        steps = (self.card.stop, self.amplifier.disable, self.switch.to_transmit)
        self._try_all("outputs could not be confirmed off", steps, OutputsUnconfirmed)

    def close(self) -> None:
        """Outputs off and every device let go, the card last: others may hang on its lines; one DeviceError lists
        all that failed."""
        devices = (self.amplifier, self.switch, self.lna, self.thermometer, self.card)
        steps = [self.outputs_off, *(d.close for d in devices if d is not None)]
        self._try_all("the platform did not close cleanly", steps, DeviceError)

    @staticmethod
    def _try_all(what: str, steps: Any, kind: type[DeviceError]) -> None:
        failures = []
        for step in steps:
            try:
                step()
            except Exception as error:  # every later step must still be tried
                failures.append(f"{getattr(step, '__qualname__', step)}: {error}")
        if failures:
            raise kind(what, why="; ".join(failures), remedy="switch the amplifier's mains off by hand")
