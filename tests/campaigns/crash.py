"""Deaths of the program that owns the devices, on the emulated wires: how long until the outputs are off.

python -m tests.campaigns.crash --page docs/crash.md --deaths 20

Each death is one of `platform-daemon measure` in the middle of a series, by a signal to it alone.  Times are those of
the emulated world, from the signal on; this process, which polls it, runs the emulators, too.
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from platform_daemon.supervisor.watch import LEASE_S
from tests.kit.data import ROOT
from tests.kit.dying_host import DyingHost, Moment
from tests.kit.emulated_lab import Lab

KILLS = (signal.SIGKILL, signal.SIGSEGV, signal.SIGABRT)
ENDS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT)
CASES: tuple[tuple[signal.Signals, Moment], ...] = (
    *((number, moment) for number in KILLS for moment in ("tx", "rx", "between")),  # type: ignore[misc]
    *((number, moment) for number in ENDS for moment in ("tx", "rx")),  # type: ignore[misc]
    (signal.SIGSTOP, "tx"), (signal.SIGSTOP, "rx"),
)  # fmt: skip
WITHIN_S = LEASE_S + 10.0
HEAD = """# Deaths of the owner

Written by `python -m tests.campaigns.crash {arguments}`; do not edit. A program that measures on the emulated
wires (cards over TCP, switch over a serial line, amplifier over USBTMC) gets a signal in TX, in RX or between
shots; its guard, a process of its own, switches the outputs off. *Amplifier*: until it is disabled. *All*: until
the card has stopped and the receiver is disconnected as well; the card's server alone takes some 0.6 s to be taken
over. SIGSTOP stands for a program that hangs: its lease is {lease:g} s. Times in s, on a computer with other work;
*met*: shots in which power met a connected receiver.

| signal | in | deaths | outputs off | amplifier: median, longest | all: median, longest | met |
| --- | --- | --- | --- | --- | --- | --- |
"""


@dataclass(frozen=True)
class Death:
    """Seconds until the amplifier was disabled and until all outputs were off; None: they were not."""

    amplifier_s: float | None
    all_s: float | None


def die(lab: Lab, number: signal.Signals, moment: Moment) -> Death:
    """One death."""
    with tempfile.TemporaryDirectory() as folder:
        host = DyingHost(lab, Path(folder))
        try:
            host.wait_for(moment)
            host.send(number)
            return Death(*host.off_after(WITHIN_S))
        except AssertionError as error:
            print(error, file=sys.stderr)
            return Death(None, None)
        finally:
            host.end()
            lab.reset_fault()  # as a person does who has looked at the platform


def told(number: signal.Signals, moment: Moment, deaths: Sequence[Death], met: int) -> str:
    """A row of the page."""
    off = [d for d in deaths if d.all_s is not None]

    def times(values: Sequence[float | None]) -> str:
        return f"{np.median(values):.3f}, {max(values):.3f}" if values else "-"  # type: ignore[arg-type, type-var]

    amplifier, every = times([d.amplifier_s for d in off]), times([d.all_s for d in off])
    return f"| {number.name} | {moment} | {len(deaths)} | {len(off)} | {amplifier} | {every} | {met} |"


def main() -> int:
    """All cases; exit code 1 if an output stayed on or power met the receiver."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deaths", type=int, default=20, help="of every case")
    parser.add_argument("--page", type=Path, help=f"write it, as {(ROOT / 'docs/crash.md').relative_to(ROOT)}")
    asked = parser.parse_args()
    rows, bad = [], False
    for number, moment in CASES:
        with tempfile.TemporaryDirectory() as folder:
            lab = Lab(Path(folder))
            try:
                deaths = [die(lab, number, moment) for _ in range(asked.deaths)]
                met = len(lab.violations())
            finally:
                lab.emulator.close()
        rows.append(told(number, moment, deaths, met))
        print(rows[-1], flush=True)
        bad = bad or met > 0 or any(d.all_s is None for d in deaths)
    if asked.page is not None:
        head = HEAD.format(arguments=f"--deaths {asked.deaths} --page docs/crash.md", lease=LEASE_S)
        asked.page.write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
