"""The simulated temperature sensor."""

from __future__ import annotations

from sim_backend.world.world import World


class SimulatedThermometer:
    """See drivers.thermometer.Thermometer."""

    def __init__(self, world: World) -> None:
        self._world = world

    def temperature_c(self) -> float:
        """See Thermometer: the true temperature with the sensor's offset, noise and resolution."""
        options, world = self._world.options.thermometer, self._world
        with world.lock:
            noise_k = options.noise_k * float(world.thermometer_rng.standard_normal())
            reading = world.temperature.celsius(world.clock.monotonic_s()) + options.offset_k + noise_k
        return reading if options.resolution_k == 0 else round(reading / options.resolution_k) * options.resolution_k

    def close(self) -> None:
        """See Thermometer."""
