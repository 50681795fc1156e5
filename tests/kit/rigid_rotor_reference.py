"""The rigid rotor a second time: Lagrange's equations from energies alone, differentiated numerically, slow and plain.

Coordinates: u and v components of n, and three angles of the rotor.  First derivatives are complex steps, exact to
rounding; the kinetic energy's second ones are central differences.  Integrated by LSODA.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

MU_0_OVER_4_PI = 1.25663706127e-6 / (4 * np.pi)
TINY, SMALL = 1e-30, 1e-5
AT_REST_M_PER_S, AT_REST_RAD_PER_S = 1e-12, 0.01  # of a contact's slip and spin, so that a quotient is one


def joined(slow, spun, bends):
    """The root of squares, bent by polynomials in the share of the second one."""
    share = spun**2 / (slow**2 + spun**2)
    return np.hypot(slow, spun) * (1 + share * (1 - share) * np.polynomial.polynomial.polyval(share, bends))


@cache
def disc():
    """Places (x, y), (n,) each, in radii, and weights (n,) of Hertz's pressure on a disc."""
    nodes, widths = np.polynomial.legendre.leggauss(160)
    depth, turn = (nodes + 1) / 2, 2 * np.pi * np.arange(720) / 720
    weight = np.repeat(3 * depth**2 * widths / 2 / turn.size, turn.size)
    radius = np.sqrt(1 - depth**2)
    return np.outer(radius, np.cos(turn)).ravel(), np.outer(radius, np.sin(turn)).ravel(), weight


def disc_friction(k):
    """Coulomb's force over mu N and torque over mu N a of a disc that slips k times as fast as its edge spins."""
    x, y, weight = disc()
    along, across = k - y, x
    speed = np.hypot(along, across)
    return weight @ (along / speed), weight @ ((x * across - y * along) / speed)


@dataclass(frozen=True)
class Reference:
    """SI; vectors in u, v, w.  friction: mu, m/N^(1/3), slowest slip m/s, slowest spin rad/s, law of creep, 0 to
    3, and coupling; None: frictionless.  damping: about the main axis, of the centre, about the other
    axes, 1/s, and the share of the thread's direction in the main axis; None: none.

    field: amplitude T and angular frequency rad/s of a sine along it.
    """

    jewel: bool
    mass: float
    inertia: float
    link: float
    arm: float
    anchor: np.ndarray
    stator: np.ndarray
    stator_moment: np.ndarray
    body_moment: np.ndarray
    weight: np.ndarray
    friction: tuple[float, float, float, float, float] | None = None
    damping: tuple[float, float, float, float] | None = None
    field: tuple[np.ndarray, float] = (np.zeros(3), 0.0)

    def rotation(self, q):
        (a, b, c), (x, y, z) = np.cos(q[2:]), np.sin(q[2:])
        about_u = np.array([[1, 0, 0], [0, a, -x], [0, x, a]])
        about_v = np.array([[b, 0, y], [0, 1, 0], [-y, 0, b]])
        about_w = np.array([[c, -z, 0], [z, c, 0], [0, 0, 1]])
        return about_w @ about_v @ about_u

    def n(self, q):
        return np.array([q[0], q[1], np.sqrt(1 - q[0] ** 2 - q[1] ** 2)])

    def centre(self, q):
        held = self.anchor - self.link * self.n(q)
        return held if self.jewel else held - self.arm * self.rotation(q)[:, 2]

    def moment(self, q):
        return self.rotation(q) @ self.body_moment

    def potential(self, q, t, centre=None):
        c, m = self.centre(q) if centre is None else centre, self.moment(q)
        x = c - self.stator
        d = np.sqrt(x @ x)
        magnets = MU_0_OVER_4_PI * (m @ self.stator_moment / d**3 - 3 * (m @ x) * (self.stator_moment @ x) / d**5)
        return magnets - m @ self.field[0] * np.sin(self.field[1] * t) - self.weight @ c

    def jacobians(self, q):
        """Of the centre's velocity and of the angular velocity, by the rates of the coordinates: (3, 5) each."""
        here, linear, angular = self.rotation(q), np.zeros((3, 5)), np.zeros((3, 5))
        for k in range(5):
            step = q + TINY * 1j * np.eye(5)[k]
            linear[:, k] = self.centre(step).imag / TINY
            spin = self.rotation(step).imag / TINY @ here.T
            angular[:, k] = [spin[2, 1], spin[0, 2], spin[1, 0]]
        return linear, angular

    def mass_matrix(self, q):
        linear, angular = self.jacobians(q)
        return self.mass * linear.T @ linear + self.inertia * angular.T @ angular

    def contact(self, q, rates, t):
        """Generalised force of the jewel's friction."""
        mu, hertz, slowest_slip, slowest_spin, law, coupling = self.friction
        linear, angular = self.jacobians(q)
        c, n = self.centre(q), self.n(q)
        pull = [-self.potential(q, t, c + TINY * 1j * np.eye(3)[k]).imag / TINY for k in range(3)]
        velocity, omega = linear @ rates, angular @ rates
        load = self.mass * velocity @ velocity / self.link - n @ pull
        slip, spin = velocity - self.arm * np.cross(omega, n), omega @ n
        a = hertz * load ** (1 / 3)
        size = np.linalg.norm(slip)
        turn = (1 - law) * np.hypot(spin, slowest_spin) + law * (abs(spin) + slowest_spin)
        creeping = (1 - law) * np.hypot(size, slowest_slip) + law * (size + slowest_slip)
        if law == 2:  # at each point of the disc
            square = size**2 + slowest_slip**2
            stuck = 15 * np.pi / 16 * square**1.5 / (square + slowest_slip**2)
            force = -mu * load * slip / joined(square**0.5, 8 * a * spin / (3 * np.pi), (0.0640, -0.0424, 0.1118))
            torque = 3 * np.pi / 16 * a**2 * mu * load * spin / joined(stuck, a * spin, (0.1360, -0.0990, 0.2132))
            return linear.T @ force + angular.T @ (np.cross(-self.arm * n, force) - torque * n)
        if law == 3:  # Coulomb's at each point of the disc
            slid, edge = np.hypot(size, slowest_slip), a * np.hypot(spin, slowest_spin)
            push, twist = disc_friction(slid / edge)
            force, torque = -mu * load * push * slip / slid, mu * load * a**2 * twist * spin / edge
            return linear.T @ force + angular.T @ (np.cross(-self.arm * n, force) - torque * n)
        if law == 4:  # by the tangent, of the disc or of each alone
            size, bare = max(size, AT_REST_M_PER_S), np.hypot(spin, AT_REST_RAD_PER_S)
            if coupling:
                push, twist = disc_friction(size / (a * bare))
                twist *= 16 / (3 * np.pi)
                slides = turns = np.tanh(np.hypot(size, a * bare) / slowest_slip)
            else:
                push = twist = 1.0
                slides, turns = np.tanh(size / slowest_slip), np.tanh(bare / slowest_spin)
            force = -mu * load * push * slides * slip / size
            torque = 3 * np.pi / 16 * a * mu * load * twist * turns * spin / bare
            return linear.T @ force + angular.T @ (np.cross(-self.arm * n, force) - torque * n)
        force = -mu * load * slip / (creeping + coupling * 8 * a * turn / (3 * np.pi))
        torque = 3 * np.pi / 16 * a * mu * load * spin / (turn + coupling * 15 * np.pi / 16 * size / a)
        return linear.T @ force + angular.T @ (np.cross(-self.arm * n, force) - torque * n)

    def loss(self, q, rates):
        """Generalised force of the damping."""
        about, side, lean, share = self.damping
        linear, angular = self.jacobians(q)
        own, along = self.rotation(q)[:, 2], self.n(q)
        axis = along if self.jewel else own + share * (along - own)
        main = np.outer(axis, axis) / (axis @ axis)
        torque = -2 * self.inertia * (about * main + lean * (np.eye(3) - main)) @ (angular @ rates)
        return linear.T @ (-2 * self.mass * side * (linear @ rates)) + angular.T @ torque

    def acceleration(self, t, q, rates):
        slope = np.array([self.potential(q + TINY * 1j * np.eye(5)[k], t).imag / TINY for k in range(5)])
        change = [(self.mass_matrix(q + SMALL * e) - self.mass_matrix(q - SMALL * e)) / (2 * SMALL) for e in np.eye(5)]
        inertial = np.array([0.5 * rates @ change[k] @ rates for k in range(5)])
        inertial -= sum(rates[k] * change[k] for k in range(5)) @ rates
        push = self.contact(q, rates, t) if self.friction else 0.0
        push = push + self.loss(q, rates) if self.damping else push
        return np.linalg.solve(self.mass_matrix(q), inertial - slope + push)

    def moved(self, q, seconds):
        """Moment's unit vector and n, (3,) each, after so many seconds from rest at q (5,)."""
        found = solve_ivp(
            lambda t, y: np.concatenate([y[5:], self.acceleration(t, y[:5], y[5:])]),
            (0.0, seconds),
            np.concatenate([q, np.zeros(5)]),
            method="LSODA",
            rtol=1e-10,
            atol=1e-12,
        )
        end = found.y[:5, -1]
        return self.moment(end) / np.linalg.norm(self.body_moment), self.n(end)
