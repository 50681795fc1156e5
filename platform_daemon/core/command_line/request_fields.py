"""Fields of requests that options are derived from: written by `python -m tests.kit.request_fields`, see there."""

# ruff: noqa: E501

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Lowest and highest value that a field takes, in its own unit; None: there is none."""

    low: float | None = None
    low_open: bool = False
    """The lowest value itself is not allowed."""
    high: float | None = None
    high_open: bool = False
    """The highest value itself is not allowed."""

    def text(self, unit: float) -> str:
        """As `0<x<=600` or `x>0`, in a unit of this SI value."""
        if self.high is None and self.low is not None:
            return f"x{'>' if self.low_open else '>='}{self.low / unit:g}"
        low = "" if self.low is None else f"{self.low / unit:g}{'<' if self.low_open else '<='}"
        return f"{low}x" + ("" if self.high is None else f"{'<' if self.high_open else '<='}{self.high / unit:g}")


@dataclass(frozen=True, kw_only=True)
class RequestField:
    """One field of a request."""

    kind: type
    """bool, int, float or str; str where several types are allowed."""
    help: str
    """The description of the field; what holds where it is left out is called its default."""
    default: Any = None
    required: bool = False
    many: bool = False
    """It is a list of values of this kind."""
    limits: Limits | None = None
    """Of a number: the model refuses others."""


REQUEST_FIELDS: dict[str, dict[str, RequestField]] = {
    "AcquisitionRequest": {
        "resonator": RequestField(
            kind=str,
            help="Resonator: thread, jewel, or another one of GET /resonators; on the command line also the path of a file.",
            required=True,
        ),
        "shots": RequestField(kind=int, help="Excited shots.", default=1, limits=Limits(low=0, high=1000000)),
        "blank_shots": RequestField(
            kind=int,
            help="Shots without excitation before them, in which the noise is measured.",
            default=0,
            limits=Limits(low=0, high=10000),
        ),
        "sequence.f_tx_hz": RequestField(
            kind=float, help="Excitation frequency, Hz; default: the preset's.", limits=Limits(low=0.01, high=20000.0)
        ),
        "sequence.tx_periods": RequestField(
            kind=int,
            help="Whole periods of the excitation, in the TX window; default: the preset's.",
            limits=Limits(low=1, high=100000),
        ),
        "sequence.field_t": RequestField(
            kind=float,
            help="Excitation field, T: amplitude of the sine at the rotor, at most what the platform allows; default: the preset's.",
            limits=Limits(low=0, low_open=True, high=1.0),
        ),
        "sequence.axis": RequestField(
            kind=str,
            help="Axis of the excitation: x, y, z, or three numbers, as 1,0,0.5, for a direction in world axes; default: the preset's.",
        ),
        "sequence.switch_s": RequestField(
            kind=float,
            help="From the end of TX to the first RX sample, s, at most 10; default: the preset's.",
            limits=Limits(low=0, low_open=True, high=10.0),
        ),
        "sequence.guard_samples": RequestField(
            kind=int,
            help="Samples between amplifier off and receiver connect, 1 to 100000; default: the preset's.",
            limits=Limits(low=1, high=100000),
        ),
        "sequence.rx_s": RequestField(
            kind=float, help="RX window, s; default: the preset's.", limits=Limits(low=0, low_open=True, high=600.0)
        ),
        "sequence.waveform": RequestField(
            kind=str, help="Shape of a half period of the field: sine, or rectangle; default: the preset's."
        ),
        "sequence.duty": RequestField(
            kind=float,
            help="Share of a half period in which a rectangle is not zero, 0.05 to 1; default: the preset's.",
            limits=Limits(low=0.05, high=1),
        ),
        "sequence.chirp_hz": RequestField(
            kind=float,
            help="Change of the frequency from the start of TX to its end, linear in time, Hz; f_tx_hz is that at the start; default: the preset's.",
            limits=Limits(low=-20000.0, high=20000.0),
        ),
        "sequence.phase_rad": RequestField(
            kind=float,
            help="Phase of the field at the start of TX, rad; default: the preset's.",
            limits=Limits(low=-7.0, high=7.0),
        ),
        "sequence.phase_plan": RequestField(
            kind=str,
            help="none: as the frequency says; model: the field follows the velocity of the resonator's model, integrated forward from rest; last_fit: the same with the values of the last good fit of the series, from the second shot on; default: the preset's.",
        ),
        "sequence.f_nat_tolerance": RequestField(
            kind=float,
            help="The plan is the best in the worst case of f_nat off by so much either way, relative, 0 to 0.02; default: the preset's.",
            limits=Limits(low=0, high=0.02),
        ),
        "sequence.pause_s": RequestField(
            kind=float, help="Wait between shots, s; default: the preset's.", limits=Limits(low=0, high=86400.0)
        ),
        "preset": RequestField(
            kind=str,
            help="shipped: the resonator's preset as it ships; tuned: the one that tune has kept, which must be there; or the name of a sequence, one of GET /sequences, whose keys go before those of the resonator's preset; on the command line also the path of a file. Missing: the tuned one if there is one.",
        ),
        "window": RequestField(
            kind=str, help="Evaluation window of the on-line fits: n50, d30, or seconds.", default="d30"
        ),
        "variant": RequestField(
            kind=str, help="Model of the on-line fits, declared or adopted; default: the resonator's."
        ),
        "beyond_side_modes": RequestField(
            kind=bool, help="Allow a field above the highest that a ramp has found for this resonator; it is logged."
        ),
        "sample": RequestField(kind=str, help="Name of the sample, one line, for the record.", default=""),
        "operator": RequestField(kind=str, help="Who measures, one line, for the record.", default=""),
        "comment": RequestField(
            kind=str, help="What else is to be kept, for the record; may have several lines.", default=""
        ),
    },
    "CalibrationRequest": {
        "name": RequestField(kind=str, help="Name of the file, without version and date; default: the kind."),
        "frequencies_hz": RequestField(
            kind=float,
            help="Frequencies, Hz, two different ones at least.",
            default=(100.0, 212.0, 424.0, 636.0, 848.0, 1272.0, 2120.0, 4000.0, 8000.0),
            many=True,
        ),
        "repetitions": RequestField(
            kind=int, help="Shots per direction and frequency.", default=2, limits=Limits(low=1, high=1000)
        ),
        "listen_s": RequestField(
            kind=float,
            help="Length of a shot, s; receive only.",
            default=0.4,
            limits=Limits(low=0, low_open=True, high=60),
        ),
        "amplifier_v": RequestField(
            kind=float, help="Amplitude on each coil, V; transmit only.", default=1.0, limits=Limits(low=0.001)
        ),
        "temperature_span_c": RequestField(
            kind=float,
            help="The calibration holds within so many degrees Celsius of the temperatures at which it was made.",
            default=5.0,
            limits=Limits(low=0, low_open=True),
        ),
    },
    "CharacteriseRequest": {
        "alpha": RequestField(
            kind=float,
            help="Level of significance of all comparisons together, 1e-12 to 0.5.",
            default=0.001,
            limits=Limits(low=1e-12, high=0.5, high_open=True),
        ),
        "tune": RequestField(
            kind=bool,
            help="Tune first: the ramp and the shots are made with the sequence that it finds.",
            default=False,
        ),
    },
    "PredictionRequest": {
        "resonator": RequestField(kind=str, help="Name of a resonator, one of GET /resonators.", required=True),
        "phi_max_rad": RequestField(
            kind=float,
            help="Largest deflection, rad; default: the paper's, or, with a manufacturing error, what the drive makes.",
            limits=Limits(low=0, low_open=True, high=1.5, high_open=True),
        ),
        "noise_am2_per_s": RequestField(
            kind=float,
            help="Standard deviation of the noise of x, y, z per sample, A m^2/s.",
            default=(0.014, 0.021, 0.055),
            many=True,
        ),
        "sampling_rate_hz": RequestField(
            kind=float, help="Sampling rate, Hz.", default=61035.15625, limits=Limits(low=0, low_open=True)
        ),
        "fixed": RequestField(kind=str, help="Public names of parameters that are held.", default=[], many=True),
        "variant": RequestField(
            kind=str, help="Model that is to be fitted, declared or adopted; default: the resonator's."
        ),
        "terms": RequestField(kind=str, help="Further torque terms, as quadratic_drag.", default=[], many=True),
        "estimate_adopted": RequestField(
            kind=bool,
            help="Estimate what an adopted model holds: strengths of torques, not their time constants and the like; or a manufacturing error, with the distance of the magnets and the damping of the side modes.",
            default=False,
        ),
        "sequence.f_tx_hz": RequestField(
            kind=float, help="Excitation frequency, Hz; default: the preset's.", limits=Limits(low=0.01, high=20000.0)
        ),
        "sequence.tx_periods": RequestField(
            kind=int,
            help="Whole periods of the excitation, in the TX window; default: the preset's.",
            limits=Limits(low=1, high=100000),
        ),
        "sequence.field_t": RequestField(
            kind=float,
            help="Excitation field, T: amplitude of the sine at the rotor, at most what the platform allows; default: the preset's.",
            limits=Limits(low=0, low_open=True, high=1.0),
        ),
        "sequence.axis": RequestField(
            kind=str,
            help="Axis of the excitation: x, y, z, or three numbers, as 1,0,0.5, for a direction in world axes; default: the preset's.",
        ),
        "sequence.switch_s": RequestField(
            kind=float,
            help="From the end of TX to the first RX sample, s, at most 10; default: the preset's.",
            limits=Limits(low=0, low_open=True, high=10.0),
        ),
        "sequence.guard_samples": RequestField(
            kind=int,
            help="Samples between amplifier off and receiver connect, 1 to 100000; default: the preset's.",
            limits=Limits(low=1, high=100000),
        ),
        "sequence.rx_s": RequestField(
            kind=float, help="RX window, s; default: the preset's.", limits=Limits(low=0, low_open=True, high=600.0)
        ),
        "sequence.waveform": RequestField(
            kind=str, help="Shape of a half period of the field: sine, or rectangle; default: the preset's."
        ),
        "sequence.duty": RequestField(
            kind=float,
            help="Share of a half period in which a rectangle is not zero, 0.05 to 1; default: the preset's.",
            limits=Limits(low=0.05, high=1),
        ),
        "sequence.chirp_hz": RequestField(
            kind=float,
            help="Change of the frequency from the start of TX to its end, linear in time, Hz; f_tx_hz is that at the start; default: the preset's.",
            limits=Limits(low=-20000.0, high=20000.0),
        ),
        "sequence.phase_rad": RequestField(
            kind=float,
            help="Phase of the field at the start of TX, rad; default: the preset's.",
            limits=Limits(low=-7.0, high=7.0),
        ),
        "sequence.phase_plan": RequestField(
            kind=str,
            help="none: as the frequency says; model: the field follows the velocity of the resonator's model, integrated forward from rest; last_fit: the same with the values of the last good fit of the series, from the second shot on; default: the preset's.",
        ),
        "sequence.f_nat_tolerance": RequestField(
            kind=float,
            help="The plan is the best in the worst case of f_nat off by so much either way, relative, 0 to 0.02; default: the preset's.",
            limits=Limits(low=0, high=0.02),
        ),
        "sequence.pause_s": RequestField(
            kind=float, help="Wait between shots, s; default: the preset's.", limits=Limits(low=0, high=86400.0)
        ),
    },
    "RampRequest": {
        "start_t": RequestField(
            kind=float,
            help="Field of the first step, T, at which there are no side modes yet; default: half that of the preset.",
            limits=Limits(low=0, low_open=True, high=1.0),
        ),
        "step_t": RequestField(
            kind=float,
            help="Highest step upwards, T; near the threshold steps get smaller.",
            default=1e-05,
            limits=Limits(low=1e-09, high=0.001),
        ),
        "max_t": RequestField(
            kind=float,
            help="Field that it does not pass, T; default: the limit of the platform.",
            limits=Limits(low=0, low_open=True, high=1.0),
        ),
        "overdose_rate": RequestField(
            kind=float,
            help="Chance, of each step upwards, to lie above the threshold, as far as the shots before it tell.",
            default=0.25,
            limits=Limits(low=0, low_open=True, high=0.5, high_open=True),
        ),
        "false_stop_rate": RequestField(
            kind=float,
            help="Chance of calling side modes visible anywhere in a ramp where the z residual is below the visible level.",
            default=0.002,
            limits=Limits(low=0, low_open=True, high=0.5, high_open=True),
        ),
        "most_shots": RequestField(
            kind=int,
            help="Shots at one field at most, where it is in doubt.",
            default=6,
            limits=Limits(low=1, high=100),
        ),
        "predicted_by": RequestField(
            kind=str,
            help="Adopted model with a manufacturing error, NAME or NAME@VERSION, whose threshold is told beside the measured one; default: none is predicted.",
        ),
    },
    "TuneRequest": {
        "weak_field_t": RequestField(
            kind=float,
            help="Field of the first shot, T; default: a swing of some degrees by design.",
            limits=Limits(low=0, low_open=True, high=1.0),
        ),
        "max_field_t": RequestField(
            kind=float,
            help="Highest field that it may raise that to, T; default: that of the platform.",
            limits=Limits(low=0, low_open=True, high=1.0),
        ),
        "keep": RequestField(
            kind=bool, help="Keep the sequence as the resonator's preset, where the daemon keeps presets.", default=True
        ),
    },
}
