"""Which undeclared effects make the fits of N50 and D30 disagree as the paper's do (tab:model_params_fit_result)?

A search over effects of the simulated platform, single and in pairs: the resonator's own parameters and the strengths
are fitted to the published means, the lengths of the D30 windows and the nRMSE, and the explanations are ranked by
chi^2. As a program it writes docs/evidence/paper-wound.md: python -m tests.campaigns.paper_wound
"""

from __future__ import annotations

import argparse
import itertools
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.errors import PlatformError
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.result import FitResult
from sim_backend.study import play
from tests.kit.data import ROOT
from tests.kit.simulated_bench import CLOCK, Bench, specimen, timeline
from tests.kit.undeclared_shots import STEADY, calibrated_record

DOCUMENT = ROOT / "docs" / "evidence" / "paper-wound.md"
_STEADY = STEADY | {"effects__friction_scatter__enabled": False}
_REFUSED = 1e4  # residual of a published number for which the simulated fit was refused
_THREAD_LAMBDA_PER_S = 0.2465  # held in the jewel's N50 fits (tab:model_fit_params)
_NRMSE_SD = 0.01  # %, of what noise and printed digits leave
_RX_S = {"thread": 5.6, "jewel": 2.0}  # the thread's D30 window is 4.9 s long
_MOST_STEPS = 10.0  # of the first step of a strength
_DEG = math.degrees(1.0)


@dataclass(frozen=True)
class Published:
    """A number of the paper, its window, and the standard error of its mean over 100 shots."""

    window: str
    name: str
    value: float
    sd: float


def _published(rows: Mapping[str, Sequence[tuple[str, float, float]]]) -> tuple[Published, ...]:
    return tuple(Published(window, *row) for window, found in rows.items() for row in found)


PUBLISHED = {
    "thread": _published(
        {
            "n50": [("f_nat_hz", 215.53, 0.008), ("m_r_am2", 11.647e-3, 2e-7), ("lambda_per_s", 0.2466, 1.2e-4),
                    ("phi_max_deg", 21.8, 0.04), ("nrmse", 1.42, _NRMSE_SD)],
            "d30": [("f_nat_hz", 215.69, 0.008), ("m_r_am2", 11.014e-3, 4e-7), ("lambda_per_s", 0.2465, 1e-4),
                    ("phi_max_deg", 22.8, 0.04), ("nrmse", 3.33, _NRMSE_SD), ("window_s", 4.90, 0.003)],
        }
    ),
    "jewel": _published(
        {
            "n50": [("f_nat_hz", 212.93, 0.013), ("m_r_am2", 12.262e-3, 1.4e-6), ("tf_over_i_rad_per_s2", 1063.0, 37.7),
                    ("phi_max_deg", 52.4, 0.05), ("nrmse", 1.38, _NRMSE_SD)],
            "d30": [("f_nat_hz", 213.25, 0.019), ("m_r_am2", 12.028e-3, 1.43e-5), ("lambda_per_s", 0.0978, 0.0121),
                    ("tf_over_i_rad_per_s2", 1324.0, 35.3), ("phi_max_deg", 53.0, 0.06), ("nrmse", 4.39, _NRMSE_SD),
                    ("window_s", 1.28, 0.031)],
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
    _candidate("coulomb_friction", 20.0, 10.0, id="coulomb_friction"),
    _candidate("hertz_friction", 20.0, 10.0, id="hertz_friction"),
    _candidate("quadratic_drag", 1e-4, 1e-4, id="quadratic_drag"),
    _candidate("angle_dependent_damping", 0.1, 0.1, id="angle_dependent_damping"),
    _candidate("restoring_anharmonicity", 0.01, 0.01, id="restoring_anharmonicity"),
    _candidate("torsion_stiffness", 0.01, 0.01, id="torsion_stiffness"),
    _candidate("bias_torque", 1000.0, 1000.0, id="bias_torque"),
    _candidate("frequency_drift", 0.03, 0.03, id="frequency_drift"),
)
SIGNALS = (
    _candidate("channel_gain of u", -0.03, 0.01, id="channel_gain", axis="y"),
    _candidate("receive_lowpass of u", 5e-5, 5e-5, id="receive_lowpass", axis="y"),
    _candidate("channel_delay of u", 2e-5, 2e-5, id="channel_delay", axis="y"),
    _candidate("receiver_compression", 0.1, 0.1, id="receiver_compression"),
    _candidate("crosstalk of v into u", 0.01, 0.01, id="crosstalk", **{"from": "x", "to": "y"}),
)
_NON_NEGATIVE = {"coulomb_friction", "hertz_friction", "quadratic_drag", "receive_lowpass", "channel_delay"}
_START = {
    "thread": {"f_nat_hz": 215.69, "m_r_am2": 11.1e-3, "lambda_per_s": 0.2, "field_t": 215e-6},
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
    record = calibrated_record(bench, shot.volts)
    long = fit_ring_down(record, variant, "d30")
    held = {} if variant == "thread" else {"lambda_per_s": _THREAD_LAMBDA_PER_S}
    short = fit_ring_down(record, variant, "n50", fixed=held)
    return {(window, name): value for window, fit in (("n50", short), ("d30", long)) for name, value in _told(fit)}


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
        residuals: (simulated - published) / sd, in the order of PUBLISHED; of the nRMSE too, which were not fitted.
        simulated: whether they are of a simulated shot, or only by linear extrapolation.
    """

    variant: str
    labels: tuple[str, ...]
    strengths: tuple[float, ...]
    own: dict[str, float]
    residuals: tuple[float, ...]
    simulated: bool

    @property
    def chi2(self) -> float:
        """Sum of the squares without the nRMSE."""
        return float(np.sum(np.square(np.array(self.residuals)[fitted_rows(self.variant)])))


def fitted_rows(variant: str) -> NDArray[np.bool_]:
    """Numbers that are fitted: all but the nRMSE, which are quadratic in the strengths, and test what is found."""
    return np.array([p.name != "nrmse" for p in PUBLISHED[variant]])


class Search:
    """Of one resonator: derivatives by one shot for each parameter and effect, then combinations of them."""

    def __init__(self, variant: str, candidates: Sequence[Candidate] = (*TORQUES, *SIGNALS)) -> None:
        self.variant, self._names, self._candidates = variant, list(_START[variant]), candidates
        origin = _START[variant]
        points = [(origin, ())]
        points += [(origin | {name: origin[name] + _STEP[name]}, ()) for name in self._names]
        points += [(origin, (candidate.at(candidate.first),)) for candidate in candidates]
        base, *moved = [self._residuals(own, tables) for own, tables in points]
        steps = [1.0] * len(self._names) + [c.first / c.scale for c in candidates]
        self._base, self._columns = base, [(m - base) / step for m, step in zip(moved, steps, strict=True)]

    def _residuals(self, own: Mapping[str, float], tables: Sequence[Mapping[str, Any]]) -> NDArray[np.float64]:
        found = fitted_numbers(self.variant, own, tables)
        return np.array(
            [(found[p.window, p.name] - p.value) / p.sd if (p.window, p.name) in found else _REFUSED
             for p in PUBLISHED[self.variant]]
        )  # fmt: skip

    def extrapolated(self, chosen: Sequence[int]) -> Explanation:
        """By the derivatives."""
        jacobian, rows = self._jacobian(chosen), fitted_rows(self.variant)
        x = -np.linalg.lstsq(jacobian[rows], self._base[rows])[0]
        return self._told(chosen, x, self._base + jacobian @ x, simulated=False)

    def refined(self, chosen: Sequence[int], steps: int = 6) -> Explanation:
        """With a simulated shot at each step of a chord iteration, the best of them."""
        jacobian, rows = self._jacobian(chosen), fitted_rows(self.variant)
        x = -np.linalg.lstsq(jacobian[rows], self._base[rows])[0]
        best: Explanation | None = None
        for _ in range(steps):
            own, strengths = self._values(chosen, x)
            tables = [self._candidates[k].at(s) for k, s in zip(chosen, strengths, strict=True)]
            try:
                residuals = self._residuals(own, tables)
            except PlatformError:  # no such world, as with a negative friction
                break
            told = self._told(chosen, x, residuals, simulated=True)
            if best is None or told.chi2 < best.chi2:
                best = told
            if np.any(residuals[rows] == _REFUSED):
                break
            x = x - np.linalg.lstsq(jacobian[rows], residuals[rows])[0]
        return best or self.extrapolated(chosen)

    def _jacobian(self, chosen: Sequence[int]) -> NDArray[np.float64]:
        n = len(self._names)
        return np.stack([*self._columns[:n], *(self._columns[n + k] for k in chosen)], axis=1)

    def _values(self, chosen: Sequence[int], x: NDArray[np.float64]) -> tuple[dict[str, float], list[float]]:
        own = {
            name: _START[self.variant][name] + _STEP[name] * float(d) for name, d in zip(self._names, x, strict=False)
        }
        return own, [self._candidates[k].scale * float(d) for k, d in zip(chosen, x[len(self._names) :], strict=True)]

    def _told(
        self, chosen: Sequence[int], x: NDArray[np.float64], residuals: NDArray[np.float64], *, simulated: bool
    ) -> Explanation:
        own, strengths = self._values(chosen, x)
        labels = tuple(self._candidates[k].label for k in chosen)
        return Explanation(self.variant, labels, tuple(strengths), own, tuple(residuals.tolist()), simulated)

    def ranked(self, refine: int) -> list[Explanation]:
        """None, every single effect and every pair by extrapolation, the best `refine` of them simulated."""
        count = len(self._candidates)
        sets = [(), *((k,) for k in range(count)), *itertools.combinations(range(count), 2)]
        order = sorted(
            (found.chi2, chosen) for chosen in sets for found in [self.extrapolated(chosen)] if self._possible(found)
        )
        best = {chosen for _, chosen in order[:refine]} | {()}
        found = [self.refined(chosen) if chosen in best else self.extrapolated(chosen) for _, chosen in order]
        return sorted(found, key=lambda one: (not one.simulated, one.chi2))

    def _possible(self, found: Explanation) -> bool:
        """No loss is negative, and no strength is so large that the derivatives say nothing of it."""
        known = {c.label: c for c in self._candidates}
        for name, strength in zip(found.labels, found.strengths, strict=True):
            candidate = known[name]
            negative = strength < 0.0 and dict(candidate.table)["id"] in _NON_NEGATIVE
            if negative or abs(strength) > _MOST_STEPS * abs(candidate.first):
                return False
        return all(found.own.get(name, 0.0) >= 0.0 for name in ("lambda_per_s", "tf_over_i_rad_per_s2"))


def main() -> None:
    """Search, and print the ranking."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--refine", type=int, default=10, help="explanations that are simulated")
    parser.add_argument("--variant", choices=sorted(PUBLISHED), help="one of them only")
    asked = parser.parse_args()
    for variant in [asked.variant] if asked.variant else PUBLISHED:
        began = time.process_time()
        for found in Search(variant).ranked(asked.refine)[: 3 * asked.refine]:
            named = ", ".join(f"{n} {s:.4g}" for n, s in zip(found.labels, found.strengths, strict=True)) or "none"
            own = ", ".join(f"{n} {v:.6g}" for n, v in found.own.items())
            off = " ".join(
                f"{p.window}.{p.name}:{r:+.1f}" for p, r in zip(PUBLISHED[variant], found.residuals, strict=True)
            )
            print(
                f"{variant} {'simulated' if found.simulated else 'extrapolated'} {found.chi2:10.1f}  {named}  [{own}]  {off}"
            )
        print(f"{variant}: {time.process_time() - began:.0f} s of CPU time")


if __name__ == "__main__":
    main()
