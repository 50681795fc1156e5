"""The simulated reference dipole and field probe, inserted into the world in place of the rotor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.identity import Identity
from drivers.reference import FrequencyStandard
from sim_backend.options import DipoleTable, ProbeTable
from sim_backend.receive.reference_dipole import Dipole
from sim_backend.transmit.coils import AXES
from sim_backend.world.world import World

PROBE_NOISE = 15


class SimulatedReferenceDipole:
    """See drivers.reference.ReferenceDipole.  The dipole of the world is exactly that of the table."""

    def __init__(self, world: World, table: DipoleTable) -> None:
        self._world = world
        self._table = table
        world.spare_output = table.output

    def identity(self) -> Identity:
        """See ReferenceDipole."""
        return Identity("simulated", f"reference dipole, {self._table.turns_area_m2:g} m^2")

    def output(self) -> int:
        """See ReferenceDipole."""
        return self._table.output

    def moment_per_volt_am2(self, frequency_hz: float) -> complex:
        """See ReferenceDipole."""
        return Dipole(self._table, np.zeros(3)).moment_per_volt_am2(frequency_hz)

    def relative_std(self) -> float:
        """See ReferenceDipole."""
        return self._table.relative_std

    def direction_std_rad(self) -> float | None:
        """See ReferenceDipole."""
        return self._table.direction_std_rad

    def standard(self) -> FrequencyStandard | None:
        """See ReferenceDipole."""
        made = self._table.standard
        return None if made is None else FrequencyStandard(made.frequency_hz, made.relative_std, made.source)

    def feed_from_standard(self) -> bool:
        """See ReferenceDipole."""
        return self._insert("x", by_standard=True)

    def turn(self, axis: str) -> bool:
        """See ReferenceDipole."""
        return self._insert(axis, by_standard=False)

    def _insert(self, axis: str, *, by_standard: bool) -> bool:
        from scipy.spatial.transform import Rotation  # which a command that inserts nothing does not need

        direction = Rotation.from_rotvec(self._table.tilt_rad).apply(np.eye(3)[AXES.index(axis)])
        self._world.insert(Dipole(self._table, direction, by_standard), np.array(self._table.position_m))
        return True

    def remove(self) -> None:
        """See ReferenceDipole."""
        self._world.insert(None, np.zeros(3))


class SimulatedFieldProbe:
    """See drivers.reference.FieldProbe."""

    def __init__(self, world: World, table: ProbeTable) -> None:
        self._world = world
        self._table = table

    def identity(self) -> Identity:
        """See FieldProbe."""
        return Identity("simulated", "three-axis field probe")

    def relative_std(self) -> float:
        """See FieldProbe."""
        return self._table.relative_std

    def put(self) -> bool:
        """See FieldProbe."""
        self._world.insert(None, np.array(self._table.position_m), empty=True)
        return True

    def field_t(self) -> NDArray[np.float64]:
        """See FieldProbe: the true field with white noise."""
        from sim_backend.receive.inserted import field_t  # here: they load the compiler
        from sim_backend.receive.receiver import sample_times

        setup, result = self._world.shot_simulator.result()
        times_s = sample_times(setup)
        true_t = field_t(setup.options.coils, result.cuts, times_s, np.array(self._table.position_m))
        noise = setup.rng(PROBE_NOISE).standard_normal(true_t.shape)
        return np.asarray(true_t + self._table.noise_t * noise)

    def remove(self) -> None:
        """See FieldProbe."""
        self._world.insert(None, np.zeros(3))
