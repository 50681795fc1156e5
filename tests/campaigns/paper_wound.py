"""Which undeclared effects make the fits of N50 and D30 disagree as the paper's do (tab:model_params_fit_result)?

A search over effects of the simulated platform, single and a torque with a signal: the resonator's own parameters and
the strengths are fitted to the published means and the lengths of the D30 windows; the nRMSE test what is found. As a
program it prints each explanation with its chi^2: python -m tests.campaigns.paper_wound --variant thread
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.errors import PlatformError
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.result import FitResult
from sim_backend.study import play
from tests.kit.simulated_bench import CLOCK, FIELD_T, Bench, specimen, timeline
from tests.kit.undeclared_shots import STEADY, calibrated_record

_STEADY = STEADY | {"effects__friction_scatter__enabled": False}
_REFUSED = 1e4  # residual of a published number for which the simulated fit was refused
_THREAD_LAMBDA_PER_S = 0.2465  # held in the jewel's N50 fits (tab:model_fit_params)
_WINDOW_SD_S = 0.05  # the paper does not say how it reads the end of D30; a waveform's peak is not its rms
_NRMSE_SD = 0.01  # %, of what noise and printed digits leave
_RX_S = {"thread": 5.6, "jewel": 2.0}  # the thread's D30 window is 4.9 s long
_RECEIVED_S = {"thread": 15.0, "jewel": 2.05}  # tab:measurement_parameter; then the next shot begins
_LONGEST = 10.0  # of a step, in the scales of the parameters
_DEG = math.degrees(1.0)
_SHOTS_OF_THE_PAPER = 100


@dataclass(frozen=True)
class Published:
    """A number of the paper, its window, the standard error of its mean over 100 shots, and how far the shots scatter;
    None: as the standard error says."""

    window: str
    name: str
    value: float
    sd: float
    scatter: float | None = None

    @property
    def deviation(self) -> float:
        """From shot to shot."""
        return math.sqrt(_SHOTS_OF_THE_PAPER) * self.sd if self.scatter is None else self.scatter


def _published(rows: Mapping[str, Sequence[tuple[Any, ...]]]) -> tuple[Published, ...]:
    return tuple(Published(window, *row) for window, found in rows.items() for row in found)


PUBLISHED = {
    "thread": _published(
        {
            "n50": [("f_nat_hz", 215.53, 0.008), ("m_r_am2", 11.647e-3, 2e-7), ("lambda_per_s", 0.2466, 1.2e-4),
                    ("phi_max_deg", 21.8, 0.04), ("nrmse", 1.42, _NRMSE_SD)],
            "d30": [("f_nat_hz", 215.69, 0.008), ("m_r_am2", 11.014e-3, 4e-7), ("lambda_per_s", 0.2465, 1e-4),
                    ("phi_max_deg", 22.8, 0.04), ("nrmse", 3.33, _NRMSE_SD), ("window_s", 4.90, _WINDOW_SD_S, 0.01)],
            "step": [("psi_start_deg", 2.0, 0.17)],
        }
    ),
    "jewel": _published(
        {
            "n50": [("f_nat_hz", 212.93, 0.013), ("m_r_am2", 12.262e-3, 1.4e-6), ("tf_over_i_rad_per_s2", 1063.0, 37.7),
                    ("phi_max_deg", 52.4, 0.05), ("nrmse", 1.38, _NRMSE_SD)],
            "d30": [("f_nat_hz", 213.25, 0.019), ("m_r_am2", 12.028e-3, 1.43e-5), ("lambda_per_s", 0.0978, 0.0121),
                    ("tf_over_i_rad_per_s2", 1324.0, 35.3), ("phi_max_deg", 53.0, 0.06), ("nrmse", 4.39, _NRMSE_SD),
                    ("window_s", 1.28, 0.031)],
            "step": [("psi_start_deg", 0.1, 0.55)],
        }
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Candidate:
    """An undeclared effect as a table of the platform, without its strength; first: where the search begins; scale: of
    a step."""

    label: str
    table: tuple[tuple[str, Any], ...]
    first: float
    scale: float

    def at(self, strength: float) -> dict[str, Any]:
        """The table of the platform."""
        return dict(self.table) | {"strength": strength}


def _candidate(label: str, first: float, scale: float, **table: Any) -> Candidate:
    return Candidate(label, tuple(table.items()), first, scale)


TORQUES = (
    _candidate("coulomb_friction", 25.0, 10.0, id="coulomb_friction"),
    _candidate("hertz_friction", 20.0, 10.0, id="hertz_friction"),
    _candidate("quadratic_drag", 1e-4, 1e-4, id="quadratic_drag"),
    _candidate("angle_dependent_damping", 0.1, 0.1, id="angle_dependent_damping"),
    _candidate("restoring_anharmonicity", 0.01, 0.01, id="restoring_anharmonicity"),
    _candidate("torsion_stiffness", 0.01, 0.01, id="torsion_stiffness"),
    _candidate("bias_torque", 1000.0, 1000.0, id="bias_torque"),
    _candidate("frequency_drift", 0.03, 0.03, id="frequency_drift"),
    _candidate("frequency_drift that settles in 0.35 s", -0.2, 0.02, id="frequency_drift", tau_s=0.35),
)
SIGNALS = (
    _candidate("channel_gain of u", -0.03, 0.01, id="channel_gain", axis="y"),
    _candidate("receive_lowpass of u", 5e-5, 5e-5, id="receive_lowpass", axis="y"),
    _candidate("channel_delay of u", 2e-5, 2e-5, id="channel_delay", axis="y"),
    _candidate("receiver_compression", 0.1, 0.1, id="receiver_compression"),
    _candidate("crosstalk of v into u", 0.01, 0.01, id="crosstalk", **{"from": "x", "to": "y"}),
)
_NON_NEGATIVE = {"coulomb_friction", "hertz_friction", "quadratic_drag", "receive_lowpass", "channel_delay"}
UNFITTED = ("nrmse", "psi_start_deg")
"""What tests an explanation: the residuals, quadratic in the strengths, and the step of psi_start from N50 to D30."""
_START = {
    "thread": {"f_nat_hz": 215.7, "m_r_am2": 11.15e-3, "lambda_per_s": 0.2466, "field_t": 215e-6},
    "jewel": {"f_nat_hz": 213.2, "m_r_am2": 12.1e-3, "lambda_per_s": 0.1, "tf_over_i_rad_per_s2": 1300.0,
              "field_t": 490e-6},
}  # fmt: skip
_STEP = {"f_nat_hz": 0.05, "m_r_am2": 5e-5, "lambda_per_s": 0.01, "tf_over_i_rad_per_s2": 30.0, "field_t": 3e-6}


def fitted_numbers(variant: str, own: Mapping[str, float], undeclared: Sequence[Mapping[str, Any]]) -> dict[Any, float]:
    """What the fits of N50 and D30 find of one shot of a resonator with these effects; by (window, name)."""
    bench = Bench(None, undeclared=[dict(effect) for effect in undeclared], seed=1, **_STEADY)
    base = specimen(variant)
    measured = {name: value for name, value in own.items() if name != "field_t"}
    rotor = base.model_copy(update={"measured": base.measured.model_copy(update=measured)})
    program = timeline(bench.channels[0], own["field_t"], rx=int(_RX_S[variant] * CLOCK.rate_hz))
    (shot,) = play(bench.backend, rotor, program, shots=1, lna_gain=40.0)
    return _fitted(bench, variant, shot.volts)


def _fitted(bench: Bench, variant: str, volts: NDArray[np.float32]) -> dict[Any, float]:
    """Of one shot, (3, n) V."""
    record = calibrated_record(bench, volts)
    long = fit_ring_down(record, variant, "d30")
    held = {} if variant == "thread" else {"lambda_per_s": _THREAD_LAMBDA_PER_S}
    short = fit_ring_down(record, variant, "n50", fixed=held)
    found = {(window, name): value for window, fit in (("n50", short), ("d30", long)) for name, value in _told(fit)}
    if short.parameters and long.parameters:
        step_rad = long.parameters["psi_start_rad"].value - short.parameters["psi_start_rad"].value
        found["step", "psi_start_deg"] = _DEG * math.remainder(step_rad, math.tau)
    return found


def _told(fit: FitResult) -> Iterator[tuple[str, float]]:
    for name, estimate in fit.parameters.items():
        yield name, estimate.value
    if fit.parameters:
        yield "phi_max_deg", _DEG * fit.parameters["phi_max_rad"].value
    if fit.nrmse is not None:
        yield "nrmse", 100.0 * fit.nrmse
    if fit.window_s is not None:
        yield "window_s", fit.window_s


@dataclass(frozen=True)
class Explanation:
    """The best that a set of effects does.

    Attributes:
        labels, strengths: of the effects; own: of the resonator, SI.
        residuals: (simulated - published) / sd, in the order of PUBLISHED; fitted: which of them were.
    """

    variant: str
    labels: tuple[str, ...]
    strengths: tuple[float, ...]
    own: dict[str, float]
    residuals: tuple[float, ...]
    fitted: tuple[bool, ...]

    @property
    def chi2(self) -> float:
        """Sum of the squares of those that were fitted."""
        return float(np.sum(np.square(np.array(self.residuals)[np.array(self.fitted)])))


def fitted_rows(variant: str, without: Collection[str] = UNFITTED) -> NDArray[np.bool_]:
    """Numbers that are fitted: all but those that are named."""
    return np.array([p.name not in without for p in PUBLISHED[variant]])


def explain(
    variant: str, effects: Sequence[Candidate], without: Collection[str] = UNFITTED, steps: int = 6
) -> Explanation:
    """Fit the resonator and the strengths to what is published: derivatives at the start, then Broyden's steps."""
    start, rows = _START[variant], fitted_rows(variant, without)
    names = list(start)
    scale = np.array([*(_STEP[name] for name in names), *(e.scale for e in effects)])
    origin = np.array([*start.values(), *(e.first for e in effects)])

    def residuals(x: NDArray[np.float64]) -> NDArray[np.float64]:
        own, strengths = _values(names, origin + scale * x)
        tables = [e.at(s) for e, s in zip(effects, strengths, strict=True)]
        found = fitted_numbers(variant, own, tables)
        numbers = [(found[p.window, p.name] - p.value) / p.sd if (p.window, p.name) in found else _REFUSED
                   for p in PUBLISHED[variant]]  # fmt: skip
        return np.array(numbers)

    x = np.zeros(len(origin))
    here = residuals(x)
    jacobian = np.stack([residuals(step) - here for step in np.eye(len(origin))], axis=1)
    best = x, here
    for _ in range(steps):
        step = -np.linalg.lstsq(jacobian[rows], here[rows])[0]
        step *= min(1.0, _LONGEST / float(np.max(np.abs(step))))
        try:
            there = residuals(x + step)
        except PlatformError:  # no such world, as with a negative friction
            break
        if np.any(there[rows] == _REFUSED):
            break
        jacobian += np.outer(there - here - jacobian @ step, step) / float(step @ step)
        x, here = x + step, there
        best = min(best, (x, here), key=lambda one: float(np.sum(np.square(one[1][rows]))))
    own, strengths = _values(names, origin + scale * best[0])
    labels, residual = tuple(e.label for e in effects), tuple(best[1].tolist())
    return Explanation(variant, labels, tuple(strengths), own, residual, tuple(rows.tolist()))


def _values(names: Sequence[str], values: NDArray[np.float64]) -> tuple[dict[str, float], list[float]]:
    numbers = values.tolist()
    return dict(zip(names, numbers, strict=False)), numbers[len(names) :]


def numbers_of_shots(
    name: str, shots: int, seed: int = 1, pause_s: float = 0.0, fluctuation: Sequence[float] | None = None
) -> Iterator[dict[Any, float]]:
    """What the fits find of shots of a shipped resonator in the paper's field, one after the other as in the paper.

    pause_s: between the end of the paper's RX window and the next shot, s; fluctuation: share of the friction or
    Hz, and correlation time in s, in place of the resonator's own.
    """
    bench, rotor = Bench(None, seed=seed, switch__transient_v=[0.0, 0.0, 0.0]), specimen(name)
    if fluctuation is not None:
        tables = rotor.model_dump(mode="json", by_alias=True, exclude_none=True)
        (table,) = (u for u in tables["rotor"]["undeclared"] if u["id"].endswith("_fluctuation"))
        table |= {"strength": fluctuation[0], "tau_s": fluctuation[1]}
        rotor = type(rotor).model_validate(tables)
    program = timeline(bench.channels[0], FIELD_T[rotor.variant], rx=int(_RX_S[rotor.variant] * CLOCK.rate_hz))
    between_s = _RECEIVED_S[rotor.variant] - _RX_S[rotor.variant] + pause_s
    for shot in play(bench.backend, rotor, program, shots, 40.0, between_s, at_rest=False):
        yield _fitted(bench, rotor.variant, shot.volts)


def compared(variant: str, found: Sequence[Mapping[Any, float]]) -> str:
    """A line per published number: mean and deviation over the shots, the paper's, and whether they agree.

    They agree within three standard errors of the paper and three of ours, in quadrature; of the nRMSE the medians are
    compared, within a tenth.
    """
    lines, agree = [f"{variant}, {len(found)} shots: mean and deviation; the paper's"], 0
    numbers = [p for p in PUBLISHED[variant] if p.window != "step"]
    for p in numbers:
        values = np.array([one[p.window, p.name] for one in found if (p.window, p.name) in one])
        if p.name == "nrmse":
            ours, scatter, paper = float(np.median(values)), math.nan, math.nan
            near = [abs(ours - p.value) <= 0.1 * p.value]
        else:
            ours, scatter = float(values.mean()), float(values.std(ddof=1))
            paper = p.deviation
            near = [_near(ours - p.value, p.sd, scatter / math.sqrt(values.size)),
                    _near(scatter - paper, paper / math.sqrt(2.0 * _SHOTS_OF_THE_PAPER),
                          scatter / math.sqrt(2.0 * values.size))]  # fmt: skip
        agree += sum(near)
        told = " ".join("agrees" if each else "differs" for each in near)
        lines.append(f"{p.window} {p.name}: {ours:.6g} {scatter:.3g}; {p.value:.6g} {paper:.3g}: {told}")
    return "\n".join([*lines, f"{agree} of {2 * len(numbers) - 2} agree"])


def _near(difference: float, paper: float, ours: float) -> bool:
    return abs(difference) <= 3.0 * math.hypot(paper, ours)


def hypotheses() -> list[tuple[Candidate, ...]]:
    """None, each effect alone, and each torque with each signal."""
    return [(), *((c,) for c in (*TORQUES, *SIGNALS)), *itertools.product(TORQUES, SIGNALS)]


def main() -> None:
    """Search, and print each explanation as it is found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--variant", choices=sorted(PUBLISHED), help="one of them only")
    parser.add_argument("--only", action="append", help="explanations with these effects only, as `a + b`; none: ``")
    parser.add_argument("--without", action="append", default=[], help="published numbers that are not fitted")
    parser.add_argument("--with-residuals", action="store_true", help="the nRMSE are fitted, too; takes more steps")
    parser.add_argument("--resonator", help="no search: shots of this shipped resonator, as thread_published")
    parser.add_argument("--shots", type=int, default=12, help="of --resonator")
    parser.add_argument("--seed", type=int, default=1, help="of --resonator")
    parser.add_argument(
        "--pause-s", type=float, default=0.0, help="between shots of --resonator, beyond the paper's t_RX"
    )
    parser.add_argument(
        "--fluctuation", type=float, nargs=2, help="of --resonator: share of the friction or Hz, correlation time / s"
    )
    asked = parser.parse_args()
    if asked.resonator:
        found = list(numbers_of_shots(asked.resonator, asked.shots, asked.seed, asked.pause_s, asked.fluctuation))
        print(compared(specimen(asked.resonator).variant, found))
        return
    without, steps = {*UNFITTED, *asked.without}, 6
    if asked.with_residuals:
        without, steps = {"psi_start_deg", *asked.without}, 24
    for variant in [asked.variant] if asked.variant else PUBLISHED:
        for effects in hypotheses():
            label = " + ".join(e.label for e in effects)
            if asked.only is None or label in asked.only:
                print(told(explain(variant, effects, without, steps)), flush=True)


def told(found: Explanation) -> str:
    """A line."""
    named = ", ".join(f"{n} {s:.4g}" for n, s in zip(found.labels, found.strengths, strict=True)) or "none"
    own = ", ".join(f"{n} {v:.6g}" for n, v in found.own.items())
    published = PUBLISHED[found.variant]
    off = " ".join(f"{p.window}.{p.name}:{r:+.1f}" for p, r in zip(published, found.residuals, strict=True))
    return f"{found.variant}: chi2 {found.chi2:.1f} with {named}; {own}; in standard errors {off}"


if __name__ == "__main__":
    main()
