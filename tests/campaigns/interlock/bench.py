"""A simulated platform whose devices are reached over calls that fail, by an owner that may die at any of them.

The owner is the daemon's own code: its interlock and its shot.  Its death is exact: from that call on nothing that it
does reaches a device, not even what it does on its way out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

from drivers.errors import DeviceLost, DeviceTimeout, PlatformError
from drivers.platform import Platform
from drivers.power_guard import NoGuard
from drivers.registry import build_platform
from drivers.timeline import DigitalLine, Timeline
from drivers.tx_rx_switch import SwitchPosition
from platform_daemon.core.hardware.interlock import Interlock
from platform_daemon.core.hardware.shot import run_shot
from platform_daemon.core.jobs.jobs import Cancelled
from platform_daemon.core.settings import PlatformFile, load_platform, load_sequence
from sequences.compiler import ShotPlan, TransmitSide, compile_shot

Kind = Literal["lost", "unheard", "death before", "death after", "line rises"]
Script = Mapping[tuple[str, int], Kind]
DEVICES = ("card", "amplifier", "switch", "lna")
WITHOUT_WIRE = frozenset({"capabilities", "timing", "last_move_s", "on_card_lines"})
WIRINGS: dict[str, tuple[str, ...]] = {
    "as shipped": (),
    "an amplifier that is slow to go off": ("power_amplifier.turn_off_s=0.004",),
    "a wide guard": ("limits.min_guard_s=0.005",),
}
SLACK_SAMPLES = 1


class Died(DeviceLost):
    """The owner is gone: whatever it asks, no device hears of it."""


class Wire:
    """A device as its owner reaches it."""

    def __init__(self, name: str, device: Any, bench: Bench) -> None:
        self._name, self._device, self._bench = name, device, bench

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._device, name)
        if name in WITHOUT_WIRE or not callable(value):
            return value
        return lambda *args, **keys: self._bench.call(self._name, name, lambda: value(*args, **keys))


class ToldGuard(NoGuard):
    """A guard that knows whether it was told."""

    told = False

    def power_may_come(self) -> None:
        """See PowerGuard."""
        self.told = True

    def power_is_off(self) -> None:
        """See PowerGuard."""
        self.told = False


@dataclass(frozen=True)
class Job:
    """As much of a job as the interlock looks at."""

    identifier: str = "a shot"


class Bench:
    """`broken`: every time something did not hold that always must."""

    def __init__(self, wiring: str, plan: Callable[[ShotPlan], ShotPlan] = lambda plan: plan) -> None:
        file = _file(wiring)
        self._built = build_platform(file.section)
        self.world: Any = self._built.backends["simulated"].world  # type: ignore[attr-defined]
        self.broken: list[str] = []
        self.dead = False
        self._script: Script = {}
        self._calls: Counter[str] = Counter()
        self._guard_s = max(file.limits.min_guard_s, self._built.amplifier_off_s)
        self._watch_world()
        self._own()
        self.plans = {blank: plan(_plan(wiring, blank)) for blank in (False, True)}

    # --- the owner

    def _own(self) -> None:
        """A new owner.  The simulated devices are device and driver in one, and outlive it."""
        self.guard = ToldGuard()
        wires: dict[str, Any] = {name: Wire(name, getattr(self._built, name), self) for name in DEVICES}
        self.platform: Platform = replace(self._built, **wires, guard=self.guard)
        self.interlock = Interlock(self.platform)
        self.dead = False

    def restart(self) -> str:
        """Another owner proves the outputs off before anything else."""
        self._own()
        return self._done(self.interlock.prove_off)

    def call(self, device: str, command: str, do: Callable[[], Any]) -> Any:
        """One call of the owner.  Raises what the script has for it."""
        if self.dead:
            raise Died("the owner is dead")
        kind = self._script.get((device, self._calls[device]))
        self._calls[device] += 1
        if kind == "lost":
            raise DeviceTimeout("no answer", where=device)
        if kind == "death before":
            self.dead = True
            raise Died("the owner is dead")
        result = do()
        if kind == "line rises" and command == "to_transmit":  # by a loose wire, once it had fallen
            self.world.idle_lines(pa_gate=False, rx_connect=True)
        if kind == "unheard":
            raise DeviceTimeout("no answer", where=device)
        if kind == "death after":
            self.dead = True
            raise Died("the owner is dead")
        return result

    def shot(self, *, blank: bool, script: Script, cancel_at: int | None) -> str:
        """One shot as a job runs it; how it ended."""
        self._script, self._calls = script, Counter()
        seen = [0]

        def cancelled() -> bool:
            seen[0] += 1
            return cancel_at is not None and seen[0] > cancel_at

        def work(job: Any) -> None:
            raw = run_shot(self.platform, self.plans[blank], cancelled=cancelled)
            if raw.reason is not None:
                raise _Refused

        return self._done(lambda: self.interlock.run(work, Job()))  # type: ignore[arg-type]

    def prove_off(self, script: Script) -> str:
        """What a stop does."""
        self._script, self._calls = script, Counter()
        return self._done(self.interlock.prove_off)

    def reset_fault(self, script: Script) -> str:
        """Outputs off, then the amplifier's fault cleared."""
        self._script, self._calls = script, Counter()

        def do() -> None:
            self.interlock.prove_off()
            self.platform.amplifier.reset_fault()

        return self._done(do)

    def rescue(self) -> str:
        """What the guard of a dead owner does, over wires of its own."""
        return self._done(self._built.outputs_off)

    def _done(self, do: Callable[[], None]) -> str:
        try:
            do()
        except _Refused:
            ended = "refused"
        except Cancelled:
            ended = "cancelled"
        except PlatformError as error:
            ended = "died" if self.dead else type(error).__name__
        else:
            ended = "good"
        self.world.idle_lines(pa_gate=False, rx_connect=False)
        if not self.dead and self.interlock.why is None:
            self._check_off(ended)
        return ended

    # --- what must always hold

    def _watch_world(self) -> None:
        switch_on, start = self.world.amplifier, self.world.start

        def amplifier(*, enabled: bool | None = None, muted: bool | None = None) -> None:
            if enabled:
                self._check_enabling()
            switch_on(enabled=enabled, muted=muted)

        def begun(timeline: Timeline, feed: Any = None) -> float:
            self._check_apart(timeline)
            return float(start(timeline, feed))

        self.world.amplifier, self.world.start = amplifier, begun

    def _position(self) -> SwitchPosition:
        found: SwitchPosition = self.world.contacts().position(self.world.clock.monotonic_s())
        return found

    def _check_enabling(self) -> None:
        if self._position() is not SwitchPosition.TRANSMIT:
            self.broken.append(f"the amplifier was enabled with the receiver on {self._position()}")
        if not self.guard.told:
            self.broken.append("the amplifier was enabled, and the guard was not told")

    def _check_apart(self, timeline: Timeline) -> None:
        """By the lines alone, which nobody needs to have checked."""
        gates = [e for e in timeline.lines if e.line is DigitalLine.PA_GATE]
        contacts = [e for e in timeline.lines if e.line is DigitalLine.RX_CONNECT]
        least = self._guard_s * timeline.clock.rate_hz - SLACK_SAMPLES
        for gate in gates:
            for receiver in contacts:
                apart = max(receiver.start_sample - gate.stop_sample, gate.start_sample - receiver.stop_sample)
                if apart < least:
                    self.broken.append(f"gate and receiver are {apart} samples apart, {least:.0f} is the least")

    def _check_off(self, ended: str) -> None:
        """The owner lives and says that all is off."""
        if self.world.power.enabled:
            self.broken.append(f"{ended}: the amplifier is enabled afterwards")
        if self.world.is_running():
            self.broken.append(f"{ended}: the card plays afterwards")
        if self._position() is SwitchPosition.RECEIVE:
            self.broken.append(f"{ended}: the receiver is connected afterwards")

    def violations(self) -> list[str]:
        """Everything that did not hold, by the world's own record too."""
        return [*self.broken, *(v.cause for v in self.world.violations())]


@cache
def _file(wiring: str) -> PlatformFile:
    return load_platform("simulated", WIRINGS[wiring])


@cache
def _plan(wiring: str, blank: bool) -> ShotPlan:
    file = _file(wiring)
    made = build_platform(file.section)
    side = TransmitSide(
        made.transmit, made.card.capabilities(), made.switch.timing(), file.limits, made.amplifier_off_s
    )
    keys = {"tx_periods": 3, "rx_s": 0.12, "guard_samples": 400, "switch_s": 0.018}
    return compile_shot(load_sequence("jewel").model_copy(update=keys), side, blank=blank)


class _Refused(Exception):
    """The shot came back with a reason."""
