"""How far drives of equal field swing a rotor: `python -m tests.campaigns.excitation [--page FILE] [--picture FILE]`.

Six drives of the Hamburg group (repository IBIResearch/MMR-Phase-Matched-Excitation, with its constants) beside a drive
whose phase is planned by our model.  The rotor is moved by scipy's DOP853 with an equation of motion of its own that
shares nothing with the planning model but the physics; frames follow each other at once, so that the rotor still swings
when the next TX begins.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import minimize

from platform_daemon.estimation.physics.driven import DrivenModel, plan_for_all, plan_phase
from platform_daemon.estimation.physics.models import model_named
from sequences.lobes import Lobes

FRAMES, RX_S, FIELD_T = 6, 0.3, 40e-6
SMOOTHING = 4.0  # half periods, of their frequencies
SLOPE_HZ_PER_S = -100.0  # of the chirp in the first frame
DUTY = 0.7
PERIODS = (30, 60, 120)
PUBLISHED = {  # from the same simulation by another hand, degrees; by periods: the six drives, then the ideal one
    30: (17.5, 17.6, 17.7, 16.8, 16.9, 17.0, 17.7),
    60: (24.0, 29.3, 31.3, 23.7, 28.4, 30.0, 31.4),
    120: (22.1, 23.4, 29.5, 21.8, 23.4, 29.8, 50.7),
}
Field = tuple[Callable[[float], float], list[float]]  # field over time, T, and where it has corners


@dataclass(frozen=True)
class Rotor:
    """The resonator of the Hamburg settings: a sphere of 0.5 mm radius; the two factors make a plan's model wrong."""

    f_nat_hz: float = 814.0
    quality: float = 852.0
    moment_am2: float = 4 / 3 * math.pi * 0.5e-3**3 * 1.44 / (4e-7 * math.pi)
    inertia_kg_m2: float = 0.4 * 4.14e-6 * 0.5e-3**2

    @property
    def omega(self) -> float:
        """Natural angular frequency, rad/s."""
        return 2 * math.pi * self.f_nat_hz

    @property
    def push(self) -> float:
        """Angular acceleration per tesla, rad/s^2/T."""
        return self.moment_am2 / self.inertia_kg_m2


@dataclass(frozen=True)
class Swing:
    """State after a stretch (rad, rad/s), largest |phi| in it, rad, and its zeros of phi, s."""

    state: tuple[float, float]
    largest_rad: float
    crossings_s: np.ndarray


def move(rotor: Rotor, state: tuple[float, float], field: Field | None, duration_s: float) -> Swing:
    """The true motion: phi'' + (w / Q) phi' + w^2 sin phi = (m / I) B(t) cos phi."""
    w, push, damping = rotor.omega, rotor.push, rotor.omega / rotor.quality
    course, corners = (lambda _: 0.0, []) if field is None else field

    def slope(t: float, y: np.ndarray) -> list[float]:
        return [y[1], push * course(t) * math.cos(y[0]) - damping * y[1] - w * w * math.sin(y[0])]

    def crossing(_: float, y: np.ndarray) -> float:
        return float(y[0])

    def turn(_: float, y: np.ndarray) -> float:
        return float(y[1])

    edges = [0.0, *(t for t in corners if 0.0 < t < duration_s), duration_s]
    largest, crossings, y = abs(state[0]), [], np.array(state)
    for start, stop in pairwise(edges):
        found = solve_ivp(slope, (start, stop), y, "DOP853", events=(crossing, turn), rtol=1e-8, atol=1e-10)
        y = found.y[:, -1]
        crossings += found.t_events[0].tolist()
        largest = max([largest, abs(y[0]), *(abs(s[0]) for s in found.y_events[1])])
    return Swing((float(y[0]), float(y[1])), float(largest), np.array(crossings))


@dataclass(frozen=True)
class Heard:
    """What is read off an RX window: frequencies at its start and end, Hz, and the phase of phi at its end, rad."""

    start_hz: float
    end_hz: float
    phase_rad: float


def heard(swing: Swing) -> Heard:
    """From the zeros of phi, half period by half period."""
    t = swing.crossings_s
    frequency = gaussian_filter1d(0.5 / np.diff(t), SMOOTHING, mode="nearest")
    since = 2 * math.pi * float(frequency[-1]) * (RX_S - float(t[-1]))
    return Heard(float(frequency[0]), float(frequency[-1]), since + (0.0 if swing.state[0] > 0 else math.pi))


def hamburg(family: str, rectangle: bool, last: Heard | None, rotor: Rotor, tx_s: float) -> Field:
    """One of the six drives, after the RX window `last`; None: the first frame, from rest."""
    if last is None:
        start, slope, phase = rotor.f_nat_hz, SLOPE_HZ_PER_S if family == "Chirp" else 0.0, 0.0
    else:
        start = {"F0": last.end_hz, "FAvg": 0.5 * (last.start_hz + last.end_hz), "Chirp": last.end_hz}[family]
        slope = (last.start_hz - last.end_hz) / tx_s if family == "Chirp" else 0.0
        phase = last.phase_rad + 0.5 * math.pi
    # Equal heat in the coil: the mean square of a rectangle is its duty, that of a sine a half.
    height = FIELD_T * (math.sqrt(0.5 / DUTY) if rectangle else 1.0)

    def turned(t: float) -> float:
        return 2 * math.pi * (start * t + 0.5 * slope * t * t) + phase

    if not rectangle:
        return (lambda t: height * math.sin(turned(t))), []
    edge = math.sin(0.5 * math.pi * (1 - DUTY))  # a sine above this is the rectangle's on-time
    fine = np.linspace(0.0, tx_s, 400 * round(tx_s * start))
    over = np.abs(np.sin(2 * math.pi * (start * fine + 0.5 * slope * fine**2) + phase)) > edge
    corners = fine[1:][np.diff(over)].tolist()
    return (lambda t: height * math.copysign(abs(math.sin(turned(t))) > edge, math.sin(turned(t)))), corners


def planned(
    state: tuple[float, float],
    believed: Rotor,
    tx_s: float,
    duty: float | None,
    height_t: float,
    tolerance: float = 0.0,
) -> Field:
    """Our drive: the model of `believed` integrated forward from the state, a sine, or a rectangle of that duty."""
    driven = DrivenModel(
        model_named("thread"),
        believed.omega,
        (0.5 * believed.omega / believed.quality,),
        (believed.push * height_t, 0.0),
        duty,
    )
    plan = plan_for_all(driven, tx_s, tolerance) if tolerance else plan_phase(driven, tx_s, state)
    lobes = Lobes(plan.zeros_s, plan.first_sign, "sine" if duty is None else "rectangle", duty or 1.0)
    corners = plan.zeros_s.tolist()
    if duty is not None:
        halves = list(pairwise(corners))
        corners = sorted(0.5 * (a + b) + side * 0.5 * duty * (b - a) for a, b in halves for side in (-1, 1))
    return (lambda t: height_t * float(lobes.at(np.array([t]))[0])), corners


def frames(choose: Callable[[Heard | None, tuple[float, float]], Field], rotor: Rotor, tx_s: float) -> list[float]:
    """Largest deflection of every frame, degrees; `choose` is told the last RX window and the state at its end."""
    state, last, found = (0.0, 0.0), None, []
    for _ in range(FRAMES):
        tx = move(rotor, state, choose(last, state), tx_s)
        rx = move(rotor, tx.state, None, RX_S)
        found.append(math.degrees(max(tx.largest_rad, rx.largest_rad)))
        state, last = rx.state, heard(rx)
    return found


NAMES = ("F0Sin", "FAvgSin", "ChirpSin", "F0Rect", "FAvgRect", "ChirpRect")


def table_row(periods: int, rotor: Rotor) -> dict[str, list[float]]:
    """Deflections of all frames by drive, degrees: the six, and planned ones of equal energy and of equal peak."""
    tx_s = periods / rotor.f_nat_hz

    def six(name: str) -> list[float]:
        family, rectangle = name.removesuffix("Sin").removesuffix("Rect"), name.endswith("Rect")
        return frames(lambda last, _: hamburg(family, rectangle, last, rotor, tx_s), rotor, tx_s)

    def ours(duty: float | None) -> list[float]:
        return frames(lambda _, state: planned(state, rotor, tx_s, duty, FIELD_T), rotor, tx_s)

    return {name: six(name) for name in NAMES} | {SINE: ours(None), RECTANGLE: ours(1.0)}


def constant(start_hz: float, slope_hz_per_s: float) -> Field:
    """A sine of equal peak from phase 0, linear in frequency."""
    return (
        lambda t: FIELD_T * math.sin(2 * math.pi * (start_hz * t + 0.5 * slope_hz_per_s * t * t)),
        [],
    )


def from_rest(rotor: Rotor, believed: Rotor, periods: int) -> dict[str, float]:
    """Deflection at the end of one TX from rest, degrees, by drive, with a model that may be wrong."""
    tx_s = periods / rotor.f_nat_hz
    f = believed.f_nat_hz
    drives = {
        "sine": constant(f, 0.0),
        "chirp": constant(f, SLOPE_HZ_PER_S),
        SINE: planned((0.0, 0.0), believed, tx_s, None, FIELD_T),
        RECTANGLE: planned((0.0, 0.0), believed, tx_s, 1.0, FIELD_T),
        FOR_ALL: planned((0.0, 0.0), believed, tx_s, None, FIELD_T, TOLERANCE),
    }
    return {name: reached_deg(rotor, field, tx_s) for name, field in drives.items()}


def reached_deg(rotor: Rotor, field: Field, tx_s: float) -> float:
    """Amplitude at the end of a TX from rest, by the energy, degrees."""
    phi, rate = move(rotor, (0.0, 0.0), field, tx_s).state
    return math.degrees(math.acos(math.cos(phi) - 0.5 * (rate / rotor.omega) ** 2))


def best_chirp(rotor: Rotor, periods: int) -> tuple[float, float, float]:
    """Deflection, degrees, frequency at the start, Hz, and slope, Hz/s, of the chirp that swings it furthest."""
    tx_s = periods / rotor.f_nat_hz
    slope = -40.0 if periods < 60 else SLOPE_HZ_PER_S if periods < 100 else -160.0
    start = np.array([rotor.f_nat_hz, slope])
    simplex = np.array([start, start + np.array((0.25 / tx_s, 0.0)), start + np.array((0.0, 0.4 * slope))])
    options = {"maxfev": 60, "xatol": 0.02, "fatol": 1e-3, "initial_simplex": simplex}
    found = minimize(lambda x: -reached_deg(rotor, constant(*x), tx_s), start, method="Nelder-Mead", options=options)
    return -float(found.fun), float(found.x[0]), float(found.x[1])


SINE, RECTANGLE, FOR_ALL = "planned sine", "planned rectangle", "planned sine, f_nat ± 0.3 %"
TOLERANCE = 0.003
NAMES = ("F0Sin", "FAvgSin", "ChirpSin", "F0Rect", "FAvgRect", "ChirpRect")
WRONG = [(f, m) for f in (-0.003, 0.0, 0.003) for m in (-0.05, 0.0, 0.05)]


def page(periods: list[int]) -> str:
    """All tables as text in Markdown."""
    return "\n".join((*six_frames(periods), *alone(periods), *robustness(periods))) + "\n"


def six_frames(periods: list[int]) -> list[str]:
    """The table of six frames in a row."""
    lines = [HEAD, "", "| TX, periods | " + " | ".join((*NAMES, SINE, RECTANGLE)) + " |", "|---" * 9 + "|"]
    for n in periods:
        row = table_row(n, Rotor())
        told = PUBLISHED.get(n, ("-",) * 7)
        lines.append(f"| {n} | " + " | ".join(f"{row[name][-1]:.1f}" for name in row) + " |")
        lines.append(f"| {n}, by another hand | " + " | ".join(map(str, told)) + " | - |")
    return [*lines, ""]


def alone(periods: list[int]) -> list[str]:
    """The table of one TX from rest, everything known."""
    lines = [ALONE, "", "| TX, periods | best chirp | planned sine | planned rectangle |", "|---" * 4 + "|"]
    for n in periods:
        chirp, start, slope = best_chirp(Rotor(), n)
        ours = from_rest(Rotor(), Rotor(), n)
        lines.append(
            f"| {n} | {chirp:.2f} ({start:.2f} Hz, {slope:.0f} Hz/s) | {ours[SINE]:.2f} | {ours[RECTANGLE]:.2f} |"
        )
    return [*lines, ""]


def robustness(periods: list[int]) -> list[str]:
    """The table of one TX from rest with a wrong model, and the worst case of every drive."""
    rotor, names = Rotor(), ("sine", "chirp", SINE, RECTANGLE, FOR_ALL)
    lines = [ROBUST, "", "| TX, periods | f_nat | m_r | " + " | ".join(names) + " |", "|---" * 8 + "|"]
    for n in periods:
        rows = []
        for f, m in WRONG:
            believed = replace(rotor, f_nat_hz=rotor.f_nat_hz * (1 + f), moment_am2=rotor.moment_am2 * (1 + m))
            rows.append([from_rest(rotor, believed, n)[name] for name in names])
            values = " | ".join(f"{v:.1f}" for v in rows[-1])
            lines.append(f"| {n} | {100 * f:+.1f} % | {100 * m:+.0f} % | {values} |")
        worst = " | ".join(f"**{min(column):.1f}**" for column in zip(*rows, strict=True))
        lines.append(f"| **{n}** | **worst** | | {worst} |")
    return lines


HEAD = """# How far drives of equal field swing a rotor

Written by `python -m tests.campaigns.excitation --page docs/evidence/excitation-study.md`; do not edit. Rotor and
coil are those of the Hamburg group (814 Hz,
Q = 852, sphere of 0.5 mm radius, 40 µT peak); the truth is scipy's DOP853 with an equation of its own. What the
drives are: [the keys of a drive](../reference/configuration.md#excitation).

## Six frames in a row

Each TX is followed by 0.3 s of RX, and the next begins while the rotor still swings. Deflection in the sixth frame,
degrees. F0, FAvg, Chirp: frequency as at the
end of the last RX, the mean of its start and end, or from its end to its start; all begin in phase with the
velocity. The six and the planned sine have the
same heat in the coil; the planned rectangle has the same peak and duty 1, which is twice the heat. *By another
hand*: the same simulation, made
independently before; its last number is an ideal drive in phase with the velocity."""
ALONE = """## One TX from rest, everything known

Deflection at its end, degrees. *Best chirp*: start and slope searched for the largest deflection, with the truth at
hand; equal peak."""
ROBUST = """## One TX from rest, with a wrong model

What is believed of f_nat and m_r is wrong by so much, and TX planned with it. Sine and chirp (-100 Hz/s) begin at
the believed f_nat.
Deflection at the end, degrees."""


def picture(path: Path) -> None:
    """Deflection over one TX of 120 periods, and the phase of the field against the velocity."""
    from matplotlib.figure import Figure

    rotor, tx_s = Rotor(), 120 / 814.0
    figure = Figure(figsize=(8, 5), layout="constrained")
    swing, phase = figure.subplots(2, 1, sharex=True)
    drives = {
        "sine at f_nat": constant(rotor.f_nat_hz, 0.0),
        "chirp, -100 Hz/s": constant(rotor.f_nat_hz, SLOPE_HZ_PER_S),
        "planned": planned((0.0, 0.0), rotor, tx_s, None, FIELD_T),
    }
    t = np.linspace(0.0, tx_s, 12_000)
    for name, (course, _) in drives.items():
        w = rotor.omega

        def slope(time: float, y: np.ndarray, course: Callable[[float], float] = course, w: float = w) -> list[float]:
            return [
                y[1],
                rotor.push * course(time) * math.cos(y[0]) - w / rotor.quality * y[1] - w * w * math.sin(y[0]),
            ]

        y = solve_ivp(slope, (0.0, tx_s), [0.0, 0.0], "DOP853", t_eval=t, rtol=1e-8, atol=1e-10).y
        amplitude = np.degrees(np.arccos(np.clip(np.cos(y[0]) - 0.5 * (y[1] / w) ** 2, -1, 1)))
        field = np.array([course(x) for x in t])
        # Work of the field per period against what it could do in phase with the velocity.
        width = round(2 / 814.0 / (t[1] - t[0]))
        mean = np.ones(width) / width
        work = np.convolve(field * y[1], mean, "same")
        most = np.sqrt(np.convolve(field**2, mean, "same") * np.convolve(y[1] ** 2, mean, "same")) + 1e-12
        swing.plot(1e3 * t, amplitude, label=name)
        phase.plot(1e3 * t[width:-width], (work / most)[width:-width])
    swing.set_ylabel("amplitude / °")
    swing.legend()
    phase.set_ylabel("cos of the angle between\nfield and velocity")
    phase.set_xlabel("time in TX / ms")
    for axes in (swing, phase):
        axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Print the page, or write it; draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--periods", type=int, nargs="+", default=list(PERIODS))
    parser.add_argument("--page", type=Path, help="write the tables to this file")
    parser.add_argument("--picture", type=Path, help="draw the picture into this file, and nothing else")
    given = parser.parse_args()
    if given.picture is not None:
        picture(given.picture)
        return
    text = page(given.periods)
    if given.page is None:
        print(text)
    else:
        given.page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
