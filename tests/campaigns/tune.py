"""How close tune comes to the frequency of resonators that are not what their magnets say.

As a program: python -m tests.campaigns.tune
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from platform_daemon.core.settings import load_platform
from platform_daemon.processes.assembly import start_engine
from tests.kit.tunes import DESIGN_HZ, off_design, tuned

RATIOS = (0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.15)
CASES: dict[str, tuple[tuple[str, ...], dict[str, float]]] = {
    "as shipped": ((), {}),
    "10 times the noise": (("backends.simulated.noise.scale=10",), {}),
    "first field 2 uT": ((), {"weak_field_t": 2e-6}),
}


def main() -> None:
    """A line per case: how many were tuned, most shots, largest error; the temperature moves f_nat by 0.08 Hz."""
    print(f"{'bearing':8} {'case':20} {'tuned':>8} {'shots':>6} {'worst error / Hz':>17}")
    for bearing in ("thread", "jewel"):
        for name, (overrides, keys) in CASES.items():
            errors, shots = [], []
            for seed, ratio in enumerate(RATIOS):
                engine = start_engine(load_platform("simulated", (*overrides, f"backends.simulated.seed={seed}")))
                try:
                    with tempfile.TemporaryDirectory() as folder:
                        own = off_design(Path(folder), bearing, round(ratio * DESIGN_HZ, 3))
                        job = tuned(engine, Path(folder), own, **keys)
                finally:
                    engine.close()
                found = job.result.outcome
                if job.error is None and found.f_nat_hz is not None:
                    errors.append(abs(found.f_nat_hz.value - ratio * DESIGN_HZ))
                    shots.append(found.shots)
            worst = f"{max(errors):.2f}" if errors else "-"
            print(f"{bearing:8} {name:20} {len(errors)} of {len(RATIOS)} {max(shots, default=0):6} {worst:>17}")


if __name__ == "__main__":
    main()
