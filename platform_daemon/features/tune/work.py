"""Tune: from the design's natural frequency to the measured one, and to the sequence that suits the resonator."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from drivers.errors import InputError, PlatformError, SequenceRejected
from drivers.specimen import Specimen
from platform_daemon.core.schemas.requests import AcquisitionRequest, SequencePatch
from platform_daemon.core.schemas.text import counted
from platform_daemon.core.schemas.value_sources import PROCEDURE, SHIPPED
from platform_daemon.features.acquire.planning import untuned_sequence
from platform_daemon.features.procedures.bench import ProcedureBench
from platform_daemon.features.procedures.conductor import ProcedureWork
from platform_daemon.features.procedures.engine_steps import EngineSteps
from platform_daemon.features.procedures.procedure import Step, StepSequence
from platform_daemon.features.procedures.schema import ProcedureResult, StepReport, SweptValue
from sequences.limits import SafetyLimits
from sequences.request import SequenceRequest

from . import numbers
from .presets import TunedPresets, declaration_sha256
from .schema import TunedPreset, TuneOutcome, TuneRequest
from .shots import TuneShot

MOST_SHOTS = 5
SEARCH_SHOTS = 3
RAISE = 5.0  # from one field of the search to the next
SEARCH_RX_S = 1.0
AT_ITS_FREQUENCY = 0.95  # effect of a burst from which the linear growth is read
AGREE_HZ = 0.5  # of two shots
FOUND_KEYS = ("f_tx_hz", "tx_periods", "rx_s", "pause_s")
"""Keys of a sequence that tune chooses, unless they are given."""
TUNED = "f_nat was found twice"


class NotTuned(PlatformError):
    """No frequency could be trusted within the shots that tune may make."""

    title = "Not tuned"


class NothingRings(NotTuned):
    """No shot of the search made anything ring."""

    title = "Nothing rings"


@dataclass(frozen=True, kw_only=True)
class TuneBench:
    """What tune knows beforehand: the resonator, the preset that it has without being tuned, and the same with the keys
    of the request; the envelope, whether a step can be made (raises InputError), and where presets are kept."""

    specimen: Specimen
    preset: SequenceRequest
    sequence: SequenceRequest
    limits: SafetyLimits
    check: Callable[[AcquisitionRequest], object]
    presets: TunedPresets


class Tune:
    """See Procedure.  Raises InputError for a request that cannot be tuned with."""

    def __init__(self, request: TuneRequest, bench: TuneBench) -> None:
        common = request.acquisition
        if common.window is None:
            raise InputError("without fits nothing can be tuned", where="window", remedy="ask for n50 or d30")
        if common.shots != 1 or common.blank_shots:
            remedy = "leave shots and blank_shots out"
            raise InputError("tune makes one excited shot per step", where="shots", remedy=remedy)
        self.request, self._bench = request, bench
        self._design = numbers.expectation(bench.specimen)
        self._start_hz = common.sequence.f_tx_hz or self._design.f_nat_hz
        self._bench.check(_with(common, field_t=bench.sequence.field_t, axis=bench.sequence.axis))
        self._impulse_t = bench.preset.field_t * bench.preset.tx_periods
        self._cap_t = min(request.max_field_t or bench.limits.max_field_t, bench.limits.max_field_t)
        weak_t = request.weak_field_t or self._field_for(self._design.weak_rad, numbers.BROAD_PERIODS)
        highest_t = self._highest_t(numbers.BROAD_PERIODS)
        if request.weak_field_t is not None and weak_t > highest_t:
            what = f"{weak_t:g} T is above {highest_t:g} T, the highest field of the search"
            raise InputError(what, where="weak_field_t", remedy="lower it, or raise max_field_t if that is lower")
        self._search = self._ladder(min(weak_t, highest_t))
        self._found = TuneOutcome(
            kind="tune", design_f_nat_hz=self._start_hz, f_nat_hz=None, shots=0, fields_t=(), lambda_per_s=None,
            tf_over_i_rad_per_s2=None, swing_rad_per_t=None, swing_rad=None, d30_s=None, sequence=None,
        )  # fmt: skip

    title, ends_early, open_ended = "tune", TUNED, True

    @property
    def outcome(self) -> TuneOutcome:
        """See Procedure."""
        return self._found

    def outline(self) -> Sequence[Step]:
        """See Procedure: the search, and what may refine it."""
        periods = self._bench.sequence.tx_periods
        refined = self._step(self._start_hz, periods, self._highest_t(periods))
        return [*self._search, *[refined] * (MOST_SHOTS - len(self._search))]

    def steps(self) -> StepSequence:
        """See Procedure.  Raises NothingRings, NotTuned."""
        shot = yield from self._until_it_rings()
        before: TuneShot | None = None
        while True:
            if shot.fitted:
                self._found = self._found.model_copy(update={"f_nat_hz": shot.estimate("f_nat_hz")})
            alike = before is not None and before.sure and abs(shot.f_nat_hz - before.f_nat_hz) <= AGREE_HZ
            if shot.sure and alike and shot.effect > AT_ITS_FREQUENCY:
                self._settle(shot)
                return TUNED
            if self._found.shots >= MOST_SHOTS:
                raise self._not_tuned(shot)
            before = shot
            # What does not ring now was too weak: the first shot may have met a swing left over from before.
            shot = yield from self._shot(self._refined(shot))

    def conclude(self, job: str, result: ProcedureResult) -> None:
        """See Procedure."""
        if not self.request.keep or self._found.sequence is None:
            return
        preset = TunedPreset(
            resonator=self.request.acquisition.resonator,
            declaration_sha256=declaration_sha256(self._bench.specimen),
            date=datetime.now(UTC).isoformat(timespec="seconds"),
            procedure=job,
            recording=result.file,
            found=self._found,
        )
        self._found = self._found.model_copy(update={"preset": self._bench.presets.keep(preset)})

    # --- the search

    def _ladder(self, weak_t: float) -> list[Step]:
        """Broad bursts in fields up to the highest that can be made; the last one still broader.

        Raises InputError if not even the first can be made.
        """
        found = [self._step(self._start_hz, numbers.BROAD_PERIODS, weak_t)]
        self._bench.check(found[0].acquisition)
        made_t = weak_t
        raised_t = min(RAISE * weak_t, self._highest_t(numbers.BROAD_PERIODS))
        for field_t, periods in ((raised_t, numbers.BROAD_PERIODS), (self._highest_t(1), 1)):
            step = self._step(self._start_hz, periods, field_t)
            try:
                self._bench.check(step.acquisition)
                made_t = max(made_t, field_t)
            except SequenceRejected:  # coil or amplifier give less: what was found before is the highest
                self._cap_t = made_t
                step = self._step(self._start_hz, periods, made_t)
            found.append(step)
        return found

    def _until_it_rings(self) -> Generator[Step, StepReport, TuneShot]:
        from platform_daemon.features.procedures.ringing import RINGING_SPAN

        shot = None
        for step in self._search:
            shot = yield from self._shot(step)
            if shot.rings:
                return shot
        assert shot is not None
        lowest_hz, last_hz = self._start_hz / RINGING_SPAN, self._start_hz * RINGING_SPAN
        raise NothingRings(
            f"nothing rings between {lowest_hz:.4g} and {last_hz:.4g} Hz after {SEARCH_SHOTS} shots of up to "
            f"{1e6 * max(self._found.fields_t):.4g} uT",
            where=self.request.acquisition.resonator,
            why=shot.report.reason or "",
            remedy="check that the resonator is mounted, that its axis is across the field (sequence.axis), and the "
            "magnets in its file; or name a frequency to begin with (sequence.f_tx_hz), or a higher max_field_t",
        )

    def _shot(self, step: Step) -> Generator[Step, StepReport, TuneShot]:
        report = yield step
        made = step.acquisition.sequence
        assert made.f_tx_hz is not None
        assert made.tx_periods is not None
        assert made.field_t is not None
        fields = (*self._found.fields_t, made.field_t)
        self._found = self._found.model_copy(update={"shots": len(fields), "fields_t": fields})
        return TuneShot(made.f_tx_hz, made.tx_periods, made.field_t, self._start_hz, report)

    def _refined(self, shot: TuneShot) -> Step:
        """A shot at f_nat with as many periods as the preset has, whose field gives a weak swing by the last one.

        If the fit was not sure the swing doubles; where there was none the field rises to what the design asks for, or
        to five times the last; where the receiver was saturated it falls to a fifth.
        """
        periods = self._bench.sequence.tx_periods
        same_t = shot.field_t * shot.periods / periods  # so strong was the last one
        if shot.fitted:
            measured = shot.measured()
            weak = numbers.weak_swing_rad(measured.tf_over_i, measured.f_nat_hz)
            field_t = measured.field_t(weak if shot.sure else max(weak, 2 * shot.swing_rad), periods)
        elif shot.saturated:
            field_t = same_t / RAISE
        else:
            field_t = max(RAISE * same_t, self._field_for(self._design.weak_rad, periods))
        return self._step(shot.f_nat_hz, periods, min(field_t, self._highest_t(periods)))

    def _settle(self, shot: TuneShot) -> None:
        """The sequence, from the last shot."""
        measured, base, requested = shot.measured(), self._bench.sequence, self.request.acquisition.sequence
        longest_s = self._bench.limits.max_tx_s
        periods = requested.tx_periods or numbers.most_periods(measured, base.field_t, self._impulse_t, longest_s)
        expected = max(measured.swing_rad(base.field_t, periods), measured.noise_rad)
        swing = min(expected, numbers.HIGHEST_RAD)
        rx_s = requested.rx_s or numbers.listening_s(measured, swing, periods / measured.f_nat_hz)
        keys = {
            "f_tx_hz": round(numbers.mean_frequency_hz(measured.f_nat_hz, swing), 2),
            "tx_periods": periods,
            "field_t": base.field_t,
            "axis": base.axis,
            "rx_s": rx_s,
            "pause_s": numbers.pause_s(measured, swing, rx_s) if requested.pause_s is None else requested.pause_s,
        }
        sequence = requested.model_copy(update=keys)
        self._bench.check(self.request.acquisition.model_copy(update={"sequence": sequence}))
        self._found = self._found.model_copy(
            update={
                "lambda_per_s": shot.estimate("lambda_per_s"),
                "tf_over_i_rad_per_s2": shot.estimate("tf_over_i_rad_per_s2"),
                "swing_rad_per_t": measured.swing_rad_per_t,
                "swing_rad": swing,
                "d30_s": measured.falls_in_s(swing, numbers.D30 * swing),
                "sequence": sequence,
                "at_limits": numbers.limits_reached(
                    expected,
                    rx_s=None if requested.rx_s is not None else sequence.rx_s,
                    pause_s=None if requested.pause_s is not None else sequence.pause_s,
                    listened_s=rx_s,
                )
                or None,
            }
        )

    # --- parts

    def _field_for(self, swing_rad: float, periods: int) -> float:
        """The field that gives this swing by design, T."""
        return swing_rad / (self._design.swing_rad_per_t * periods)

    def _step(self, f_tx_hz: float, periods: int, field_t: float) -> Step:
        common = self.request.acquisition
        damping = self._bench.specimen.measured.lambda_per_s or 0.0
        expected = numbers.Measured(self._start_hz, damping, self._design.tf_over_i, 1.0, 1.0)
        keys = {
            "f_tx_hz": f_tx_hz,
            "tx_periods": periods,
            "field_t": field_t,
            "axis": self._bench.sequence.axis,  # not that of a preset that was tuned before
            "rx_s": SEARCH_RX_S,
            "pause_s": numbers.pause_s(expected, 2 * self._design.weak_rad, SEARCH_RX_S),
        }
        made = _with(common, **keys)
        values = (("f_tx_hz", round(f_tx_hz, 3)), ("tx_periods", periods), ("field_ut", float(f"{1e6 * field_t:.4g}")))
        origins = {key: PROCEDURE for key in keys if key != "axis"}
        if common.sequence.axis is None:
            origins["axis"] = SHIPPED
        return Step(tuple(SweptValue(key=k, value=v) for k, v in values), made, self._start_hz, origins, "tune")

    def _highest_t(self, periods: int) -> float:
        """No shot excites more than the preset does, nor leaves the envelope, T."""
        return min(self._cap_t, self._impulse_t / periods)

    def _not_tuned(self, shot: TuneShot) -> NotTuned:
        heard = "" if shot.heard is None else f"; a line at {shot.heard.frequency_hz:.5g} Hz rings"
        advice = "see the recording; keep one resonator near, check the calibration, or allow a higher max_field_t"
        return NotTuned(
            f"f_nat could not be fitted twice alike in {counted(self._found.shots, 'shot')}{heard}",
            where=self.request.acquisition.resonator,
            why=shot.report.reason or f"the last fit gives {shot.f_nat_hz:.5g} Hz",
            remedy="lower lna.gain: a weak field saturates the receiver already" if shot.saturated else advice,
        )


def _with(common: AcquisitionRequest, **keys: Any) -> AcquisitionRequest:
    return common.model_copy(update={"sequence": common.sequence.model_copy(update=keys)})


def tune_of(bench: ProcedureBench, request: TuneRequest) -> Tune:
    """The procedure, also as the first part of a characterisation.  Raises InputError."""
    engine = bench.engine
    specimen, _ = engine.catalogue.resonators.load(request.acquisition.resonator)
    plain = request.acquisition.model_copy(update={"sequence": SequencePatch()})
    tune_bench = TuneBench(
        specimen=specimen,
        preset=untuned_sequence(plain, specimen, engine.catalogue),
        sequence=untuned_sequence(request.acquisition, specimen, engine.catalogue),
        limits=engine.side.limits,
        check=lambda acquisition: EngineSteps(engine).check(acquisition, {}),
        presets=TunedPresets(engine.catalogue.tuned.folder),
    )
    return Tune(request, tune_bench)


def plan(bench: ProcedureBench, request: TuneRequest) -> ProcedureWork:
    """The work of tuning, every known step checked.  Raises InputError."""
    return bench.work(tune_of(bench, request))
