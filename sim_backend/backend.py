"""The simulated platform as a back end: one world, its devices, and operations that only a simulation has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from drivers.calibration import ReceiveCalibration, TransmitChannel
from drivers.errors import ConfigError
from drivers.specimen import Specimen
from drivers.validation import validated
from sim_backend.devices.io_card import SimulatedIoCard
from sim_backend.devices.lna import SimulatedLna
from sim_backend.devices.power_amplifier import SimulatedPowerAmplifier
from sim_backend.devices.reference import SimulatedFieldProbe, SimulatedReferenceDipole
from sim_backend.devices.tx_rx_switch import SimulatedTxRxSwitch
from sim_backend.options import (
    CalibrationTable,
    DipoleTable,
    EmptyTable,
    IoCardTable,
    LnaTable,
    ProbeTable,
    SimulatedOptions,
)
from sim_backend.receive.calibration import receive_calibration, transmit_channels
from sim_backend.world.clock import SimulatedClock
from sim_backend.world.world import World


class SimulatedThermometer:
    """See drivers.thermometer.Thermometer."""

    def __init__(self, world: World) -> None:
        self._world = world

    def temperature_c(self) -> float:
        """See Thermometer: the true temperature with the sensor's offset, noise and resolution."""
        world = self._world
        options = world.options.thermometer
        with world.lock:
            noise_k = options.noise_k * float(world.thermometer_rng.standard_normal())
            reading = world.temperature.celsius(world.clock.monotonic_s()) + options.offset_k + noise_k
        return reading if options.resolution_k == 0 else round(reading / options.resolution_k) * options.resolution_k

    def close(self) -> None:
        """See Thermometer."""


class SimulatedBackend:
    """See drivers.platform.Backend; `options` is the table `[backends.simulated]`.

    >>> backend = SimulatedBackend(tomllib.loads(text)["backends"]["simulated"])
    >>> backend.mount(specimen)
    >>> card = backend.io_card({"base_frequency_hz": 125e6, "decimation": 2048, "max_samples": 10**7})
    """

    in_process: ClassVar[bool] = True
    changes_resonators: ClassVar[bool] = True

    def __init__(self, options: Mapping[str, Any]) -> None:
        self.options = validated(SimulatedOptions, options, "backends.simulated")
        self.world = World(self.options)

    def io_card(self, options: Mapping[str, Any]) -> SimulatedIoCard:
        """See Backend."""
        return SimulatedIoCard(self.world, validated(IoCardTable, options, "io_card"))

    def tx_rx_switch(self, options: Mapping[str, Any]) -> SimulatedTxRxSwitch:
        """See Backend."""
        validated(EmptyTable, options, "tx_rx_switch")
        return SimulatedTxRxSwitch(self.world)

    def power_amplifier(self, options: Mapping[str, Any]) -> SimulatedPowerAmplifier:
        """See Backend."""
        validated(EmptyTable, options, "power_amplifier")
        return SimulatedPowerAmplifier(self.world)

    def lna(self, options: Mapping[str, Any]) -> SimulatedLna:
        """See Backend."""
        table = validated(LnaTable, options, "lna")
        self._check_gain(table.gain, "lna.gain")
        return SimulatedLna(self.world, table)

    def thermometer(self, options: Mapping[str, Any]) -> SimulatedThermometer:
        """See Backend."""
        validated(EmptyTable, options, "thermometer")
        return SimulatedThermometer(self.world)

    def transmit_channels(self, options: Mapping[str, Any]) -> tuple[TransmitChannel, ...]:
        """See Backend; fields at the centre of the coils."""
        validated(EmptyTable, options, "coils")
        return transmit_channels(self.options, np.zeros(3))

    def receive_calibration(self, options: Mapping[str, Any]) -> ReceiveCalibration:
        """See Backend."""
        table = validated(CalibrationTable, options, "calibration")
        self._check_gain(table.lna_gain, "calibration.lna_gain")
        return receive_calibration(self.options, table, np.array(table.position_m))

    def reference_dipole(self, options: Mapping[str, Any]) -> SimulatedReferenceDipole:
        """See Backend."""
        return SimulatedReferenceDipole(self.world, validated(DipoleTable, options, "reference_dipole"))

    def field_probe(self, options: Mapping[str, Any]) -> SimulatedFieldProbe:
        """See Backend."""
        return SimulatedFieldProbe(self.world, validated(ProbeTable, options, "field_probe"))

    def clock(self) -> SimulatedClock:
        """See Backend: world time."""
        return self.world.clock

    def mount(self, specimen: Specimen) -> None:
        """See Backend.  A different specimen starts at rest; the same one keeps its present motion."""
        self.world.mount(specimen)

    def ground_truth(self) -> Mapping[str, Any] | None:
        """See Backend and sim_backend/world/truth.py."""
        return self.world.truth()

    def repair(self) -> None:
        """Repair all damage and remove planned faults."""
        self.world.repair()

    def warm_up(self) -> float:
        """Compile all kernels of a shot, or load them from the cache; return the elapsed time, s."""
        from sim_backend.world.warm_up import warm_up  # here: it loads the compiler

        return warm_up()

    def _check_gain(self, gain: float, where: str) -> None:
        gains = self.options.lna.gains
        if gain not in gains:
            raise ConfigError(f"the LNA has no gain {gain}", where=where, remedy=f"use one of {gains}")
