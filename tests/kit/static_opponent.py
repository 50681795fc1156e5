"""The static analysis once more, by brute force: energy of two dipoles in SI units over angles, minimised by scipy, and
forces and torques as differences of that energy.  It shares no formula with the analysis but the conventions."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

MU_0 = 1.25663706127e-6
R, B_R, D = 1.5e-3, 1.3, 4.7e-3
MOMENT = 4 / 3 * np.pi * R**3 * B_R / MU_0
SCALE = MU_0 * MOMENT**2 / (4 * np.pi * D**3)  # J
EY, EZ = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def about_x(angle):
    return Rotation.from_rotvec([angle, 0.0, 0.0])


def energy(stator_place, stator_moment, place, moment):
    """Of two dipoles of size MOMENT, J."""
    apart = place - stator_place
    length = np.linalg.norm(apart)
    e = apart / length
    product = stator_moment @ moment - 3 * (stator_moment @ e) * (moment @ e)
    return MU_0 * MOMENT**2 / (4 * np.pi * length**3) * product


class Case:
    """A defect of size eps (rad) or dy (m) of a jewel with cup radius `span`, or a thread of that length, m."""

    def __init__(self, bearing, defect, size, span, pivot_height=D - R):
        self.bearing, self.span = bearing, span
        self.stator, self.stator_moment, self.tilt, self.rotor_tilt = np.zeros(3), EY, 0.0, 0.0
        if defect == "stator_tilt":
            self.stator_moment = about_x(size).apply(EY)
        elif defect == "rotor_tilt":
            self.rotor_tilt = size
        elif defect == "lateral":
            self.stator = size * EY
        elif defect == "jewel_tilt":
            self.tilt = size
        reach = span - R if bearing == "jewel" else span + R
        pivot = pivot_height * EZ
        self.anchor = pivot + about_x(self.tilt).apply((D + reach) * EZ - pivot)

    def pose(self, q):
        """(C, moment) for angles: a jewel's q are of C about A and of the moment; a thread's of thread and rotor."""
        if self.bearing == "jewel":
            place = self.anchor - (self.span - R) * Rotation.from_euler("xy", q[:2]).apply(EZ)
            return place, Rotation.from_euler("xz", q[2:4]).apply(-EY)
        end = self.anchor - self.span * Rotation.from_euler("xy", q[:2]).apply(EZ)
        body = Rotation.from_euler("zyx", q[2:5])
        return end - R * body.apply(EZ), body.apply(about_x(self.rotor_tilt).apply(-EY))

    def rest(self):
        """(C, moment) of least energy."""
        start = np.zeros(4 if self.bearing == "jewel" else 5)
        start[0] = self.tilt
        height = lambda q: energy(self.stator, self.stator_moment, *self.pose(q)) / SCALE  # noqa: E731
        found = minimize(height, start, method="BFGS", options={"gtol": 1e-7})
        found = minimize(
            height, found.x, method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-16, "maxiter": 4000}
        )
        return self.pose(found.x)

    def perpendicular_force(self, phi):
        """(F_perp, N; alpha, rad): moments about D, as differences of the energy when the rotor is turned about D."""
        place, moment = self.rest()
        axis = self.anchor - place
        axis = axis / np.linalg.norm(axis)
        pivot = place + (R if self.bearing == "thread" else -R) * axis
        deflected = Rotation.from_rotvec(phi * axis).apply(moment)

        def turned(turn):
            by = Rotation.from_rotvec(turn)
            return energy(self.stator, self.stator_moment, pivot + by.apply(place - pivot), by.apply(deflected))

        h = 1e-4
        about_d = np.array([(turned(-h * e) - turned(h * e)) / (2 * h) for e in np.eye(3)])
        return np.linalg.norm(about_d - (about_d @ axis) * axis) / R, np.arccos(axis @ moment)
