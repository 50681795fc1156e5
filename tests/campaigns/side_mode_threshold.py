"""z residual against field of a specimen in the simulated world, and the field at which side modes become visible.

python -m tests.campaigns.side_mode_threshold thread_imperfect jewel_imperfect
python -m tests.campaigns.side_mode_threshold thread_imperfect --from-ut 200 --to-ut 300 --tilt-deg 0.5

The protocol is the paper's ("Measurement Sequence"): 10 periods of 212 Hz along x, raised in steps of 10 uT until the z
channel shows side modes.  The world is without noise and without scatter from shot to shot, the rotor starts at rest,
and the criterion is the truth's own: the largest z residual of the RX window.
"""

from __future__ import annotations

import argparse

from sim_backend.world.side_motion import VISIBLE_AM2_PER_S
from tests.kit.side_modes import changed, truths

RANGES_UT = {"thread": (200, 300), "jewel": (480, 640)}


def main() -> None:
    """Print the table of each specimen."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("specimens", nargs="+")
    parser.add_argument("--from-ut", type=int)
    parser.add_argument("--to-ut", type=int)
    parser.add_argument("--step-ut", type=int, default=10)
    parser.add_argument("--tilt-deg", type=float)
    parser.add_argument("--side-damping", type=float)
    parser.add_argument("--friction", type=float, help="T_f/I, rad/s^2")
    given = parser.parse_args()
    for name in given.specimens:
        mounted = changed(name, given.tilt_deg, given.side_damping, given.friction)
        low, high = RANGES_UT[mounted.variant]
        fields = range(given.from_ut or low, (given.to_ut or high) + 1, given.step_ut)
        print(f"{name}\n  field / uT   amplitude / deg   z residual / Am2/s")
        first = None
        for field_ut, truth in truths(mounted, fields):
            seen = truth["side_modes_visible"]
            first = field_ut if seen and first is None else first
            values = f"{truth['amplitude_tx_end_deg']:13.2f}   {truth['z_residual_am2_per_s']:18.3f}"
            print(f"  {field_ut:10d}   {values}{'   visible' if seen else ''}")
        print(f"  main mode {truth['main_mode_hz']:.3f} Hz, decay {truth['main_mode_decay_per_s']:.4f} 1/s")
        print(f"  side modes {', '.join(f'{f:.1f}' for f in truth['side_modes_hz'])} Hz")
        print(f"  first above {VISIBLE_AM2_PER_S} Am2/s: {first} uT\n")


if __name__ == "__main__":
    main()
