"""Mistakes that are planted into the daemon's shot, interlock or timeline; each must be found."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any
from unittest.mock import patch

from drivers.platform import Platform
from drivers.timeline import DigitalLine, LineLevel
from platform_daemon.core.hardware import shot as shot_module
from platform_daemon.core.hardware.interlock import Interlock
from sequences.compiler import ShotPlan

Change = Callable[[LineLevel], LineLevel]


def same(plan: ShotPlan) -> ShotPlan:
    """Nothing is planted."""
    return plan


def _lines(change: Change) -> Callable[[ShotPlan], ShotPlan]:
    def planted(plan: ShotPlan) -> ShotPlan:
        lines = tuple(change(line) for line in plan.timeline.lines)
        return replace(plan, timeline=replace(plan.timeline, lines=lines))

    return planted


def _gate_late(line: LineLevel) -> LineLevel:
    return replace(line, stop_sample=line.stop_sample + 900) if line.line is DigitalLine.PA_GATE else line


def _contact_early(line: LineLevel) -> LineLevel:
    return replace(line, start_sample=line.start_sample - 900) if line.line is DigitalLine.RX_CONNECT else line


def _no_guard(line: LineLevel) -> LineLevel:
    return replace(line, start_sample=line.start_sample - 399) if line.line is DigitalLine.RX_CONNECT else line


def _amplifier_first(platform: Platform, plan: Any, cancelled: Any) -> None:
    platform.guard.power_may_come()
    platform.amplifier.enable()
    platform.switch.to_transmit()
    platform.lna.clear_overload()
    platform.card.program(plan.timeline)
    platform.card.arm()
    platform.amplifier.unmute()


def _guard_not_told(platform: Platform, plan: Any, cancelled: Any) -> None:
    with patch.object(platform.guard, "power_may_come", lambda: None):
        _PREPARE(platform, plan, cancelled)


_PREPARE = shot_module._prepare  # noqa: SLF001 what is to be broken


def _amplifier_stays(platform: Platform) -> None:
    platform.guard.switching_off()
    platform.card.stop()
    platform.switch.to_transmit()
    platform.guard.power_is_off()


def _says_off(interlock: Interlock) -> None:
    interlock.why = None


@dataclass(frozen=True)
class Mutant:
    """A mistake: of the plan, or of a function, which is replaced while it is planted."""

    name: str
    plan: Callable[[ShotPlan], ShotPlan] = same
    where: Any = None
    function: str = ""
    by: Any = None

    @contextmanager
    def planted(self) -> Iterator[None]:
        """While it is there."""
        if self.where is None:
            yield
            return
        with patch.object(self.where, self.function, self.by):
            yield


MUTANTS = (
    Mutant("the gate ends late", _lines(_gate_late)),
    Mutant("the receiver is connected early", _lines(_contact_early)),
    Mutant("the guard time is dropped", _lines(_no_guard)),
    Mutant("the amplifier is enabled before the receiver is off", where=shot_module, function="_prepare",
           by=_amplifier_first),
    Mutant("the switch is not read back", where=shot_module, function="_is_on_transmit", by=lambda platform: True),
    Mutant("the guard process is not told of power", where=shot_module, function="_prepare", by=_guard_not_told),
    Mutant("outputs off forgets the amplifier", where=Platform, function="outputs_off", by=_amplifier_stays),
    Mutant("outputs off is believed, not proved", where=Interlock, function="prove_off", by=_says_off),
)  # fmt: skip
