"""How much of a core it takes to read two cards, two channels each, for 15 s: `python -m tests.benchmarks.reading_cpu`.

The emulator is a process of its own, so that what is counted is the driver: sockets, records, counts to volts.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from drivers.conformance.timelines import short_shot
from drivers.red_pitaya.card import RedPitayaCard
from drivers.red_pitaya.options import card_table
from tests.kit.emulator_process import emulator

LIMIT = 0.05  # of a core
STEP_S = 0.1  # as the engine reads


def share_of_core(card: RedPitayaCard, seconds: float) -> tuple[float, float]:
    """CPU time over time while samples are read, and samples read over those that the rate promises."""
    timeline = short_shot(card.capabilities(), rx_s=seconds)
    step = round(STEP_S * timeline.clock.rate_hz)
    card.program(timeline)
    card.arm()
    card.trigger()
    done, cpu_s, began = 0, time.process_time(), time.monotonic()
    while done < timeline.total_samples:
        done += card.read(min(step, timeline.total_samples - done)).volts.shape[1]
    elapsed_s = time.monotonic() - began
    return (time.process_time() - cpu_s) / elapsed_s, timeline.duration_s / elapsed_s


def measured(windows: int, seconds: float) -> list[tuple[float, float]]:
    """Per window: share of a core, and rate over the card's."""
    with tempfile.TemporaryDirectory(prefix="reading-cpu-") as folder, emulator(Path(folder), "thread") as (_, found):
        boards = [{**at, "inputs": [0, 1], "outputs": [0]} for at in found["io_cards"]]
        card = RedPitayaCard(card_table({"boards": boards}))
        try:
            return [share_of_core(card, seconds) for _ in range(windows)]
        finally:
            card.close()


def main() -> None:
    """Command line; exit code 1 above the limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--windows", type=int, default=4)
    parser.add_argument("--seconds", type=float, default=15.0)
    options = parser.parse_args()
    found = measured(options.windows, options.seconds)
    for k, (share, rate) in enumerate(found):
        print(f"window {k + 1}: {100 * share:.2f} % of a core, {rate:.4f} of the card's rate")
    raise SystemExit(max(share for share, _ in found) > LIMIT)


if __name__ == "__main__":
    main()
