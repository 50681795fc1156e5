"""What back ends of real devices have in common: everything they do not offer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, NoReturn

from drivers.calibration import ReceiveCalibration, TransmitChannel
from drivers.clock import Clock, SystemClock
from drivers.errors import DeviceNotFound
from drivers.io_card import IoCard
from drivers.lna import Lna
from drivers.power_amplifier import PowerAmplifier
from drivers.reference import FieldProbe, ReferenceDipole
from drivers.specimen import Specimen
from drivers.thermometer import Thermometer
from drivers.tx_rx_switch import TxRxSwitch


class RealBackend:
    """See drivers.platform.Backend: real time, no ground truth, nothing to warm up.  Every device raises DeviceNotFound
    unless a subclass offers it."""

    name = "back end"
    in_process: ClassVar[bool] = False
    changes_resonators: ClassVar[bool] = False

    def io_card(self, options: Mapping[str, Any]) -> IoCard:
        """See Backend."""
        self._offers_no("io_card")

    def tx_rx_switch(self, options: Mapping[str, Any]) -> TxRxSwitch:
        """See Backend."""
        self._offers_no("tx_rx_switch")

    def power_amplifier(self, options: Mapping[str, Any]) -> PowerAmplifier:
        """See Backend."""
        self._offers_no("power_amplifier")

    def lna(self, options: Mapping[str, Any]) -> Lna:
        """See Backend."""
        self._offers_no("lna")

    def thermometer(self, options: Mapping[str, Any]) -> Thermometer:
        """See Backend."""
        self._offers_no("thermometer")

    def transmit_channels(self, options: Mapping[str, Any]) -> tuple[TransmitChannel, ...]:
        """See Backend."""
        self._offers_no("coils")

    def receive_calibration(self, options: Mapping[str, Any]) -> ReceiveCalibration:
        """See Backend."""
        self._offers_no("calibration")

    def reference_dipole(self, options: Mapping[str, Any]) -> ReferenceDipole:
        """See Backend."""
        self._offers_no("reference_dipole")

    def field_probe(self, options: Mapping[str, Any]) -> FieldProbe:
        """See Backend."""
        self._offers_no("field_probe")

    def clock(self) -> Clock:
        """See Backend."""
        return SystemClock()

    def mount(self, specimen: Specimen) -> None:
        """See Backend: the operator has done it."""

    def warm_up(self) -> object:
        """See Backend: nothing takes long the first time."""
        return None

    def ground_truth(self) -> Mapping[str, Any] | None:
        """See Backend: a real device has none."""
        return None

    def _offers_no(self, device: str) -> NoReturn:
        raise DeviceNotFound(
            f"the back end {self.name!r} has no {device}", where=device, remedy="name another back end in its table"
        )
