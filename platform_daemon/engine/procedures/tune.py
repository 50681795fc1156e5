"""Tune: from the design's natural frequency to the measured one, and to the sequence that suits the resonator."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from drivers.errors import InputError, PlatformError, SequenceRejected
from drivers.specimen import Specimen
from platform_daemon.analysis import RINGING_SPAN
from platform_daemon.schemas import (
    AcquisitionRequest,
    ParameterEstimate,
    ProcedureResult,
    StepReport,
    SweptValue,
    TunedPreset,
    TuneOutcome,
    TuneRequest,
)
from sequences.limits import SafetyLimits
from sequences.request import SequenceRequest

from ..tuned_presets import TunedPresets, declaration_sha256
from . import tune_numbers as numbers
from .procedure import Step, StepSequence

MOST_SHOTS = 5
SEARCH_SHOTS = 3
RAISE = 5.0  # from one field of the search to the next
SEARCH_RX_S = 1.0
SURE_HZ = 0.1  # standard deviation of f_nat that ends it
AGREE_HZ = 0.5  # of two shots
TUNED = "f_nat was found twice"


class NotTuned(PlatformError):
    """No frequency could be trusted within the shots that tune may make."""

    title = "Not tuned"


class NothingRings(NotTuned):
    """No shot of the search made anything ring."""

    title = "Nothing rings"


@dataclass(frozen=True)
class TuneBench:
    """What tune knows beforehand: the resonator, the sequence that it has without being tuned, the envelope, whether a
    step can be made (raises InputError), and where presets are kept."""

    specimen: Specimen
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
        cap_t = min(request.max_field_t or bench.limits.max_field_t, bench.limits.max_field_t)
        weak_t = request.weak_field_t or self._field_for(self._design.weak_rad, numbers.BROAD_PERIODS)
        if request.weak_field_t is not None and weak_t > cap_t:
            remedy = "lower it, or raise max_field_t"
            raise InputError(
                f"{weak_t:g} T is above {cap_t:g} T, the highest field", where="weak_field_t", remedy=remedy
            )
        self._search = self._ladder(min(weak_t, cap_t), cap_t)
        self._cap_t = self._search[-1].acquisition.sequence.field_t or cap_t
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
        refined = self._step(self._start_hz, self._bench.sequence.tx_periods, self._cap_t)
        return [*self._search, *[refined] * (MOST_SHOTS - len(self._search))]

    def steps(self) -> StepSequence:
        """See Procedure.  Raises NothingRings, NotTuned."""
        report = yield from self._until_it_rings()
        before: float | None = None
        while True:
            assert report.heard is not None or report.fitted
            f_nat, sure = self._learn(report)
            if sure and before is not None and abs(f_nat - before) <= AGREE_HZ and self._near(report, f_nat):
                self._settle(report)
                return TUNED
            if self._found.shots >= MOST_SHOTS:
                raise self._not_tuned(report)
            before = f_nat if sure else None
            step = self._refined(report, f_nat)
            report = yield from self._shot(step)
            if not (report.fitted or report.heard):
                raise self._not_tuned(report)

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

    def _ladder(self, weak_t: float, cap_t: float) -> list[Step]:
        """Broad bursts in fields up to the highest that can be made; the last one still broader.

        Raises InputError if not even the first can be made.
        """
        found = [self._step(self._start_hz, numbers.BROAD_PERIODS, weak_t)]
        self._bench.check(found[0].acquisition)
        for field_t, periods in ((min(RAISE * weak_t, cap_t), numbers.BROAD_PERIODS), (cap_t, 1)):
            step = self._step(self._start_hz, periods, field_t)
            try:
                self._bench.check(step.acquisition)
            except SequenceRejected:  # coil or amplifier give less: what was made last is the highest
                last = found[-1].acquisition.sequence.field_t
                assert last is not None
                step = self._step(self._start_hz, periods, last)
            found.append(step)
        return found

    def _until_it_rings(self) -> Generator[Step, StepReport, StepReport]:
        report = None
        for step in self._search:
            report = yield from self._shot(step)
            if report.fitted or report.heard is not None:
                return report
        assert report is not None
        lowest_hz, last_hz = self._start_hz / RINGING_SPAN, self._start_hz * RINGING_SPAN
        raise NothingRings(
            f"nothing rings between {lowest_hz:.4g} and {last_hz:.4g} Hz after {SEARCH_SHOTS} shots of up to "
            f"{1e6 * max(self._found.fields_t):.4g} uT",
            where=self.request.acquisition.resonator,
            why=report.reason or "",
            remedy="check that the resonator is mounted, that its axis is across the field (sequence.axis), and the "
            "magnets in its file; or name a frequency to begin with (sequence.f_tx_hz), or a higher max_field_t",
        )

    def _shot(self, step: Step) -> Generator[Step, StepReport, StepReport]:
        report = yield step
        field_t = step.acquisition.sequence.field_t
        assert field_t is not None
        self._found = self._found.model_copy(
            update={"shots": self._found.shots + 1, "fields_t": (*self._found.fields_t, field_t)}
        )
        self._last = step
        return report

    # --- what a shot tells

    def _learn(self, report: StepReport) -> tuple[float, bool]:
        """f_nat as this shot has it, Hz, and whether it is to be trusted."""
        fitted = report.results.get("f_nat_hz")
        if fitted is None:
            assert report.heard is not None
            return report.heard.frequency_hz, False
        self._found = self._found.model_copy(update={"f_nat_hz": _estimate(report, "f_nat_hz")})
        return fitted.median, fitted.std is not None and fitted.std <= SURE_HZ

    def _near(self, report: StepReport, f_nat_hz: float) -> bool:
        """The burst was so near to f_nat that its effect is that at f_nat within 5 %."""
        return self._effect(f_nat_hz) > 0.95

    def _effect(self, f_nat_hz: float) -> float:
        made = self._last.acquisition.sequence
        assert made.tx_periods is not None
        assert made.f_tx_hz is not None
        return numbers.effect_beside(made.tx_periods, made.f_tx_hz, f_nat_hz)

    def _refined(self, report: StepReport, f_nat_hz: float) -> Step:
        """A shot at f_nat with as many periods as the preset has, whose field gives a weak swing by the last one.

        Where the last one was too weak for a fit the field rises, by the design or to five times the last.
        """
        periods = self._bench.sequence.tx_periods
        made = self._last.acquisition.sequence
        assert made.field_t is not None
        swing = report.results.get("phi_max_rad")
        if swing is not None:
            assert made.tx_periods is not None
            effect = max(self._effect(f_nat_hz), 0.1)
            per_t = swing.median / (made.field_t * made.tx_periods * effect)
            field_t = self._design.weak_rad / (per_t * periods)
        else:
            by_design_t = self._field_for(self._design.weak_rad, periods)
            field_t = max(RAISE * made.field_t * (made.tx_periods or 1) / periods, by_design_t)
        return self._step(f_nat_hz, periods, min(field_t, self._cap_t))

    def _settle(self, report: StepReport) -> None:
        """The sequence, from the last shot."""
        values = {name: report.results[name].median for name in report.results}
        made = self._last.acquisition.sequence
        assert made.field_t is not None
        assert made.tx_periods is not None
        snr = report.heard.snr if report.heard is not None else 1.0
        tf_over_i = max(values.get("tf_over_i_rad_per_s2", 0.0), 0.0)
        lost = numbers.friction_loss_rad(tf_over_i, values["f_nat_hz"], made.tx_periods)
        driven = (values["phi_max_rad"] + lost) / self._effect(values["f_nat_hz"])
        measured = numbers.Measured(
            f_nat_hz=values["f_nat_hz"],
            lambda_per_s=max(values["lambda_per_s"], 0.0),  # of hardly any damping noise makes a negative one
            tf_over_i=tf_over_i,
            swing_rad_per_t=driven / (made.field_t * made.tx_periods),
            noise_rad=values["phi_max_rad"] / snr,
        )
        base, asked = self._bench.sequence, self.request.acquisition.sequence
        field_t = min(base.field_t, self.request.max_field_t or base.field_t)
        most = base.field_t * base.tx_periods
        periods = asked.tx_periods or numbers.most_periods(measured, field_t, most, self._bench.limits.max_tx_s)
        swing = min(max(measured.swing_rad(field_t, periods), measured.noise_rad), numbers.HIGHEST_RAD)
        tx_s = periods / measured.f_nat_hz
        rx_s = asked.rx_s or numbers.listening_s(measured, swing, tx_s)
        found = {
            "f_tx_hz": round(numbers.mean_frequency_hz(measured.f_nat_hz, swing), 2),
            "tx_periods": periods,
            "field_t": field_t,
            "axis": base.axis,
            "rx_s": rx_s,
            "pause_s": numbers.pause_s(measured, swing, rx_s) if asked.pause_s is None else asked.pause_s,
        }
        sequence = self.request.acquisition.sequence.model_copy(update=found)
        self._bench.check(self.request.acquisition.model_copy(update={"sequence": sequence}))
        self._found = self._found.model_copy(
            update={
                "lambda_per_s": _estimate(report, "lambda_per_s"),
                "tf_over_i_rad_per_s2": _estimate(report, "tf_over_i_rad_per_s2"),
                "swing_rad_per_t": measured.swing_rad_per_t,
                "swing_rad": swing,
                "d30_s": measured.falls_in_s(swing, numbers.D30 * swing),
                "sequence": sequence,
            }
        )

    # --- parts

    def _field_for(self, swing_rad: float, periods: int) -> float:
        """The field that gives this swing by design, T."""
        return swing_rad / (self._design.swing_rad_per_t * periods)

    def _step(self, f_tx_hz: float, periods: int, field_t: float) -> Step:
        common = self.request.acquisition
        damping = self._bench.specimen.measured.lambda_per_s
        expected = numbers.Measured(self._start_hz, damping, self._design.tf_over_i, 1.0, 1.0)
        keys = {
            "f_tx_hz": f_tx_hz,
            "tx_periods": periods,
            "field_t": field_t,
            "axis": self._bench.sequence.axis,  # not that of a preset that was tuned before
            "rx_s": SEARCH_RX_S,
            "pause_s": numbers.pause_s(expected, 2 * self._design.weak_rad, SEARCH_RX_S),
        }
        made = common.model_copy(update={"sequence": common.sequence.model_copy(update=keys)})
        values = (("f_tx_hz", round(f_tx_hz, 3)), ("tx_periods", periods), ("field_ut", float(f"{1e6 * field_t:.4g}")))
        return Step(tuple(SweptValue(key=k, value=v) for k, v in values), made, self._start_hz)

    def _not_tuned(self, report: StepReport) -> NotTuned:
        heard = "nothing" if report.heard is None else f"a line at {report.heard.frequency_hz:.5g} Hz"
        return NotTuned(
            f"{heard} rings, but f_nat could not be fitted twice alike in {self._found.shots} shots",
            where=self.request.acquisition.resonator,
            why=report.reason or f"last f_nat: {self._found.f_nat_hz}",
            remedy="see the recording; keep one resonator near, check the calibration, or allow a higher max_field_t",
        )


def _estimate(report: StepReport, name: str) -> ParameterEstimate | None:
    found = report.results.get(name)
    return None if found is None else ParameterEstimate(value=found.median, std=found.std)
