"""How fast the rigid rotor is computed: seconds of motion per second of one core.

python -m tests.benchmarks.rigid_rotor
"""

from __future__ import annotations

import time
from dataclasses import replace

from drivers.specimen import Specimen
from sim_backend.rotor.dynamics import dynamics
from sim_backend.rotor.rotor import effective
from tests.kit.simulated_bench import FIELD_T, Bench, specimen

WINDOW_S = {"thread": 15.0, "jewel": 2.0}
FIELDS_T = {"thread": (215e-6, 270e-6), "jewel": (490e-6, 610e-6)}
REPEATS = 5


def seconds_of_processor(mounted: Specimen, field_t: float) -> float:
    """Least processor time of the RX window's motion, after a drive of this field, s."""
    bench = Bench(None, noise__scale=0.0)
    bench.backend.mount(mounted)
    bench.shot(field_t, rx=16)
    setup, result = bench.backend.world.shot_simulator.result()
    assert setup.rotor is not None
    model, least = dynamics(effective(mounted)), float("inf")
    start = model.rest()
    start = replace(
        start,
        phi_rad=result.phi_rad,
        phi_dot_rad_per_s=result.phi_dot_rad_per_s,
        stuck=False,
        internal_state=result.internal_state,
    )
    for _ in range(REPEATS):
        begin = time.thread_time()
        model.advance(0.0, WINDOW_S[mounted.variant], start)
        least = min(least, time.thread_time() - begin)
    return least


def main() -> None:
    """Print a line for every specimen and field."""
    print("specimen            field / uT   window / s   processor / s   times faster than real time")
    for variant in FIELD_T:
        for name in (variant, f"{variant}_imperfect"):
            for field_t in FIELDS_T[variant]:
                spent, window_s = seconds_of_processor(specimen(name), field_t), WINDOW_S[variant]
                print(f"{name:18}  {1e6 * field_t:10.0f}   {window_s:10.1f}   {spent:13.3f}   {window_s / spent:27.1f}")


if __name__ == "__main__":
    main()
