"""An independent source of angles: DOP853 from turning point to turning point, for any torque."""

import math

import numpy as np
from scipy.integrate import solve_ivp

RATE, NATURAL_HZ = 400.0, 2.0


def half_cycles(torque, amplitude, s, rtol=3e-14):
    """(phi, v), (2, n), at the dimensionless times s (n,) of the motion from rest at `amplitude`, s = 0.

    torque(phi, v, sigma, s): sigma is the direction of motion. Friction that holds the rotor ends the motion.
    """

    def turning(_, y):
        return y[1]

    turning.terminal = True
    out, begin, phi = np.zeros((2, s.size)), 0.0, amplitude
    while begin < s[-1]:
        sigma = -math.copysign(1.0, phi)
        if torque(phi, 0.0, sigma, begin) * sigma <= 0.0:
            out[0, s >= begin] = phi
            break
        turning.direction = -sigma
        leg = solve_ivp(
            lambda x, y, sigma=sigma: [y[1], torque(y[0], y[1], sigma, x)], (begin, begin + 40), [phi, 0.0],
            method="DOP853", rtol=rtol, atol=max(1e-17, 1e-3 * rtol), events=turning, dense_output=True,
        )  # fmt: skip
        inside = (s >= begin) & (s < leg.t[-1])
        if inside.any():
            out[:, inside] = leg.sol(s[inside])
        begin, phi = leg.t[-1], leg.y[0, -1]
    return out


def swing(amplitude, periods, viscous=0.004, dry=0.0, more_at_rest=0.0, speed=1.0):
    """Angle of a pendulum of 2 Hz at 400 Hz, without noise.

    dry, more_at_rest: dry friction, and what it has more at rest, which falls with the speed v as exp(-|v| / speed), in
    units of I w^2 and w.
    """
    s = 2 * math.pi * NATURAL_HZ * np.arange(int(periods * RATE / NATURAL_HZ)) / RATE

    def torque(phi, v, sigma, _):
        return -math.sin(phi) - 2 * viscous * v - sigma * (dry + more_at_rest * math.exp(-abs(v) / speed))

    return half_cycles(torque, amplitude, s, 1e-11)[0]


def kicked(amplitude, periods, at_period, change, viscous=0.004, dry=0.0):
    """The same with a sudden `change` of its velocity (in units of w) so many periods after the start."""
    s = 2 * math.pi * NATURAL_HZ * np.arange(int(periods * RATE / NATURAL_HZ)) / RATE
    begin, y, out = 0.0, np.array([amplitude, 0.0]), np.zeros(s.size)
    for until in (2 * math.pi * at_period, float(s[-1]) + 1e-9):
        while begin < until:
            sigma = math.copysign(1.0, y[1] if abs(y[1]) > 1e-9 else -y[0])

            def turning(_, y):
                return y[1]

            turning.terminal, turning.direction = True, -sigma
            leg = solve_ivp(
                lambda x, y, sigma=sigma: [y[1], -math.sin(y[0]) - 2 * viscous * y[1] - sigma * dry], (begin, until), y,
                method="DOP853", rtol=1e-11, atol=1e-14, events=turning, dense_output=True,
            )  # fmt: skip
            inside = (s >= begin) & (s <= leg.t[-1])
            out[inside] = leg.sol(s[inside])[0]
            begin, y = float(leg.t[-1]), leg.y[:, -1]
            if leg.status == 1:
                y = np.array([y[0], 0.0])
        y = y + np.array([0.0, change])
    return out


def bristle(amplitude, periods, friction, displacement, viscous=0.004):
    """The same with a contact that is a spring before it slides (Dahl), in units of I w^2 and rad."""
    s = 2 * math.pi * NATURAL_HZ * np.arange(int(periods * RATE / NATURAL_HZ)) / RATE

    def rates(_, y):
        pull = -math.sin(y[0]) - 2 * viscous * y[1] - friction * y[2]
        return [y[1], pull, (y[1] - abs(y[1]) * y[2]) / displacement]

    begin = amplitude, 0.0, math.tanh(amplitude / displacement)  # as it was swinging so before
    return solve_ivp(rates, (0.0, s[-1]), begin, "LSODA", s, rtol=1e-10, atol=1e-12, max_step=0.1).y[0]
