"""One strike: its moment, the blow, and how long the outputs stayed on."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from platform_daemon.core.guard.watch import LEASE_S
from tests.campaigns.crash.bench import Bench, Moment
from tests.campaigns.crash.strikes import LATE_S, Strike

_WITHIN_S = LEASE_S + 15.0
_BEFORE, _AFTER = 2, 2
"""Intervals between shots that tell what is usual, once for a series; shots after a strike that it must survive."""
_WAITS_S = 1.0
"""Where outputs are still on then, nothing is disturbed by the next daemon's start."""
_LONGEST_S = 10.0


@dataclass
class Came:
    """What came of a strike, s after it: power_s until power could no longer reach the coils, amplifier_s until the
    amplifier was disabled, all_s until all outputs were off, late_s the most that a shot was late; None: not asked.

    missed: what must not be; met: how often power met a connected receiver; wall_s: that the strike has taken in all.
    """

    name: str
    moment: Moment
    power_s: float | None = None
    amplifier_s: float | None = None
    all_s: float | None = None
    late_s: float | None = None
    missed: list[str] = field(default_factory=list)
    met: int = 0
    wall_s: float | None = None


def strike(bench: Bench, what: Strike, moment: Moment, meanwhile: Callable[[], None]) -> Came:
    """Do it.  meanwhile: called once nothing more is measured that it could disturb; it starts the next daemon.

    Raises NotThere if its moment does not come, AssertionError if what it needs cannot be had.
    """
    began = time.monotonic()
    bench.begin()
    met, came = len(bench.lab.violations()), Came(what.name, moment)
    if what.must == "go on" and bench.usual_s is None:
        bench.usual_s = _period_s(bench)
    bench.wait_for(moment)
    since_s, since = bench.world.clock.monotonic_s(), time.monotonic()
    what.do(bench)
    if what.must == "go on":
        _goes_on(bench, came)
    elif what.must == "wiring":
        _wiring_alone(bench, came, since)
    else:
        _goes_off(
            bench, came, since, meanwhile if what.ends == "daemon" else lambda: None, or_on=what.must == "off or on"
        )
    if what.must != "go on" and (came.all_s is not None or came.missed):
        came.power_s = bench.power_until_s(since_s)
    if what.ends == "daemon":
        meanwhile()
    _afterwards(bench, what, came)
    came.met = len(bench.lab.violations()) - met
    came.wall_s = time.monotonic() - began
    return came


def _period_s(bench: Bench) -> float:
    bench.look_anew()
    return float(np.median(np.diff(_starts(bench, _BEFORE + 1))))


def _starts(bench: Bench, count: int) -> list[float]:
    """When the next shots begin, s."""
    known, until = len(bench.starts), time.monotonic() + _LONGEST_S * count
    while len(bench.starts) < known + count and time.monotonic() < until:
        bench.look()
        time.sleep(1e-3)
    return bench.starts[known:]


def _goes_on(bench: Bench, came: Came) -> None:
    before = bench.starts[-1:]  # the shot that was struck, or the one before
    starts = [*before, *_starts(bench, _AFTER)]
    if len(starts) < _AFTER + 1:
        bench.go_on()
        came.missed.append("the series has ended, or a shot did not come in time")
        return
    assert bench.usual_s is not None
    came.late_s = float(max(np.diff(starts)) - bench.usual_s)
    if came.late_s > LATE_S:
        came.missed.append(f"a shot was {came.late_s:.2f} s late")
    if not bench.stop_port_answers():
        came.missed.append("the port for stop does not answer")
    bench.go_on()
    until = time.monotonic() + _WITHIN_S
    while not bench.answers():
        if time.monotonic() > until:
            came.missed.append("the web does not answer")
            return


def _goes_off(bench: Bench, came: Came, since: float, meanwhile: Callable[[], None], *, or_on: bool) -> None:
    shots = bench.world.shots
    while time.monotonic() - since < _WITHIN_S:
        if time.monotonic() - since > _WAITS_S:
            meanwhile()
        if or_on and bench.world.shots > shots + 2:
            came.amplifier_s = came.all_s = None
            return
        if came.amplifier_s is None and not bench.world.power.enabled:
            came.amplifier_s = time.monotonic() - since
        if not bench.outputs_on:
            came.all_s = time.monotonic() - since
            came.amplifier_s = came.all_s if came.amplifier_s is None else came.amplifier_s
            meanwhile()
            if _stays_off(bench):
                return
            came.amplifier_s = came.all_s = None  # between two shots: it has not noticed yet
        time.sleep(1e-3)
    came.missed.append("outputs stayed on")


def _stays_off(bench: Bench) -> bool:
    """No shot begins in the next half second."""
    until, shots = time.monotonic() + 0.5, bench.world.shots
    while time.monotonic() < until:
        if bench.outputs_on or bench.world.shots > shots:
            return False
        time.sleep(1e-3)
    return True


def _what_stop_said(bench: Bench, came: Came) -> None:
    """Where somebody has asked."""
    asks, bench.asks = bench.asks, None
    if asks is None:
        return
    asks.join(_WITHIN_S)
    if '"hung":true' not in (bench.told or ""):
        came.missed.append(f"POST /stop was answered {bench.told}")


def _wiring_alone(bench: Bench, came: Came, since: float) -> None:
    while bench.card_on:
        assert time.monotonic() - since < _WITHIN_S, "the shot does not end"
        time.sleep(1e-3)
    came.all_s = time.monotonic() - since


def _afterwards(bench: Bench, what: Strike, came: Came) -> None:
    """The outputs are off, whoever is left; and what lives can measure again, which the next strike begins with."""
    if what.must == "go on":
        return  # with the next strike, in the same series
    powered = bench.world.power.enabled  # who dies while no power can come leaves no fault
    if what.ends == "daemon":
        bench.stop_daemon()
    else:
        bench.wait_for_hardware()
        _what_stop_said(bench, came)
        bench.lab.control("clear_faults")
        bench.end_series()
    if what.must == "wiring":
        fault = bench.reset_fault()
        if fault is None and powered:
            came.missed.append("no fault stood")
    until = time.monotonic() + _WITHIN_S  # a device that could not be reached is tried again and again
    while bench.outputs_on:
        if time.monotonic() > until:
            came.missed.append("outputs are on at the end")
            return
        time.sleep(0.05)
