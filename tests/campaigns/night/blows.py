"""What is done to the lab and the daemon in the night: faults of the fault campaign's catalogue, and deaths."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass

import numpy as np

from tests.campaigns.crash.bench import Bench
from tests.campaigns.faults.catalogue import Cell, cells
from tests.campaigns.faults.trial import Fault, draw
from tests.kit.processes import NoSuchChild

DEATHS = ("web killed", "worker killed", "server of a card killed")
_STAYS_S = 3.0, 15.0
_CHUNKS = 12  # of a shot, about: which one a fault of the data stream meets is left to chance


@dataclass(frozen=True)
class Blow:
    """name; from when until when it may strike, s since 1970; struck: it did."""

    name: str
    began: float
    mended: float
    struck: bool


def strike(bench: Bench, seed: int, number: int) -> Blow:
    """The next one: it is there for some seconds, then what broke is whole again."""
    chance = np.random.default_rng([seed, number, 1])
    began = time.time()
    if chance.random() < 0.2:
        name = str(chance.choice(DEATHS))
        struck = _kill(bench, name)
        return Blow(name, began, time.time(), struck)
    fault = _fault(seed, number)
    bench.world.faults.clear()
    before = bench.world.shots
    _arm(bench, fault)
    time.sleep(chance.uniform(*_STAYS_S))
    wire = bench.lab.emulator.faults.get(fault.cell.device)
    struck = bench.world.shots > before if fault.cell.world or wire is None else bool(wire.strikes)
    bench.lab.control("repair")
    return Blow(fault.cell.name, began, time.time(), struck)


def trip(bench: Bench) -> Blow:
    """The amplifier latches a fault, which only a person resets."""
    began = time.time()
    bench.lab.control("trip_amplifier")
    return Blow("the amplifier has tripped, and is not reset", began, float("inf"), True)


def in_the_night(cell: Cell) -> bool:
    """Can it strike a daemon that runs, and be over without a person?"""
    return not cell.site.early and cell.site.phase != "self-test" and cell.kind != "amplifier_trip"


def _fault(seed: int, number: int) -> Fault:
    chosen = [k for k, cell in enumerate(cells()) if in_the_night(cell)]
    index = int(np.random.default_rng([seed, number]).choice(chosen))
    return draw(seed, index + number * len(cells()))


def _arm(bench: Bench, fault: Fault) -> None:
    if fault.cell.world:
        bench.lab.control("inject", kind=fault.cell.kind)
        return
    after = {}
    if fault.write is not None:
        chunk, record = fault.write
        after = {"after": 2 * (chunk % _CHUNKS) + record}
    bench.lab.control("wire_fault", **fault.wire, **after)


def _kill(bench: Bench, name: str) -> bool:
    if name == "server of a card killed":
        bench.lab.kill_server(0)
        time.sleep(2.0)
        bench.lab.start_server(0)
        return True
    try:
        os.kill(bench.web() if name == "web killed" else bench.worker(), signal.SIGKILL)
    except NoSuchChild:  # it is being started anew
        return False
    return True
