"""Commands, faults, deaths and rescues in any order."""

from __future__ import annotations

from collections import Counter
from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from sim_backend.world.faults import KINDS as WORLD_FAULTS
from tests.campaigns.interlock.bench import DEVICES, WIRINGS, Bench, Script

VISITS: Counter[tuple[str, str]] = Counter()
"""How often each step ended how, in this process."""
SCRIPTS = st.dictionaries(
    st.tuples(st.sampled_from(DEVICES), st.integers(0, 12)),
    st.sampled_from(["lost", "unheard", "death before", "death after"]),
    min_size=1,
    max_size=3,
)
LASTING = frozenset({"switch_stuck", "switch_welded"})


class InterlockMachine(RuleBasedStateMachine):
    """`mutate`: changes a bench before it is used; a subclass plants a mistake by it."""

    @staticmethod
    def make(wiring: str) -> Bench:
        """The bench of a run."""
        return Bench(wiring)

    def __init__(self) -> None:
        super().__init__()
        self.bench: Bench | None = None
        self.disturbed = False

    def _visit(self, step: str, ended: str) -> None:
        VISITS[step, ended] += 1

    @property
    def _bench(self) -> Bench:
        assert self.bench is not None
        return self.bench

    @initialize(wiring=st.sampled_from(sorted(WIRINGS)))
    def begin(self, wiring: str) -> None:
        """A platform, and its first owner."""
        self.bench = self.make(wiring)
        self._visit("start", wiring)

    def _alive(self) -> bool:
        return self.bench is not None and not self.bench.dead

    def _dead(self) -> bool:
        return self.bench is not None and self.bench.dead

    @precondition(_alive)
    @rule(blank=st.booleans())
    def shot(self, blank: bool) -> None:
        """Nothing is wrong with it."""
        ended = self._bench.shot(blank=blank, script={}, cancel_at=None)
        self._visit("blank shot" if blank else "shot", ended)
        if not self.disturbed and ended != "good":
            self._bench.broken.append(f"an undisturbed shot ended as {ended}")

    @precondition(_alive)
    @rule(script=SCRIPTS, blank=st.booleans())
    def shot_with_broken_calls(self, script: Script, blank: bool) -> None:
        """Commands or their answers are lost, or the owner dies at one of them."""
        self._visit("shot with broken calls", self._bench.shot(blank=blank, script=script, cancel_at=None))

    @precondition(_alive)
    @rule(at=st.integers(0, 3), script=st.one_of(st.just({}), SCRIPTS))
    def shot_with_a_loose_line(self, at: int, script: Script) -> None:
        """The receiver's line rises by itself, once somebody had let it fall."""
        ended = self._bench.shot(blank=False, script={**script, ("switch", at): "line rises"}, cancel_at=None)
        self._visit("shot with a loose line", ended)

    @precondition(_alive)
    @rule(at=st.integers(0, 4))
    def cancelled_shot(self, at: int) -> None:
        """Somebody cancels it."""
        self._visit("cancelled shot", self._bench.shot(blank=False, script={}, cancel_at=at))

    @precondition(_alive)
    @rule(kind=st.sampled_from(sorted(WORLD_FAULTS)), script=st.one_of(st.just({}), SCRIPTS))
    def shot_with_a_device_fault(self, kind: str, script: Script) -> None:
        """A device fails in it."""
        world: Any = self._bench.world
        world.faults.inject(kind, world.shots + 1)
        self.disturbed = self.disturbed or kind in LASTING or kind == "amplifier_trip"
        ended = self._bench.shot(blank=False, script=script, cancel_at=None)
        world.faults.clear()
        self._visit(f"shot with {kind}", ended)

    @precondition(_alive)
    @rule(script=st.one_of(st.just({}), SCRIPTS))
    def stop(self, script: Script) -> None:
        """Everything off."""
        self._visit("stop", self._bench.prove_off(script))

    @precondition(_alive)
    @rule(script=st.one_of(st.just({}), SCRIPTS))
    def reset_fault(self, script: Script) -> None:
        """The amplifier's fault is cleared."""
        self._visit("reset of a fault", self._bench.reset_fault(script))

    @precondition(_alive)
    @rule()
    def trip(self) -> None:
        """The amplifier trips while nothing runs."""
        self._bench.world.trip_amplifier()
        self.disturbed = True
        self._visit("trip", "done")

    @precondition(_alive)
    @rule()
    def repair(self) -> None:
        """A person frees contacts and clears the amplifier's fault."""
        self._bench.world.repair()
        ended = self._bench.reset_fault({})
        self.disturbed = ended != "good"
        self._visit("repair", ended)

    @rule(seconds=st.sampled_from([1e-3, 0.02, 0.1, 1.0, 60.0]))
    def wait(self, seconds: float) -> None:
        """Time goes by; a card whose owner is dead plays on."""
        if self.bench is not None:
            self.bench.world.clock.sleep(seconds)
            self._visit("wait, owner dead" if self.bench.dead else "wait", "done")

    @precondition(_dead)
    @rule()
    def rescue(self) -> None:
        """The guard of the dead owner switches off."""
        self._visit("rescue", self._bench.rescue())

    @precondition(_dead)
    @rule()
    def restart(self) -> None:
        """Another owner is started, with or without the guard having been there."""
        self._visit("restart", self._bench.restart())

    @invariant()
    def nothing_is_broken(self) -> None:
        """Power never met the receiver, and all that makes sure of it holds."""
        if self.bench is not None:
            assert not self.bench.violations(), self.bench.violations()
