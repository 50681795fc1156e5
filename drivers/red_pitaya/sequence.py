"""Compiles a timeline to the step sequence and the sines of each board.

A board plays steps of equal length.  Per step its two outputs are gated by enable bits (the sines run on underneath,
their phase counted from the trigger) or hold a level, and its slow analog outputs take a level.  After the last step
everything is zero, so a sequence has one step more than its last edge and always ends by itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivers.errors import SequenceRejected
from drivers.red_pitaya.layout import FIRST_ANALOG_CHANNEL, Layout
from drivers.timeline import Burst, DigitalLine, Timeline

COMPONENTS = 3
HIGH_V = 1.8  # full scale of the slow analog outputs
LONGEST_STEP = 128  # samples: the step that ends a sequence is dead time
MAX_SAMPLES = 2**25  # ring of the recording
RING_STEPS = 8192  # of a card's memory: one that its server refills no longer plays its steps again after so many
PHASE_TOLERANCE_RAD = 1e-6
OUTPUT_FULL_SCALE_V = 1.0


@dataclass(frozen=True, kw_only=True)
class Sine:
    """`amplitude_v * sin(2 pi frequency_hz t + phase_rad)` on an output (0 or 1), t from the trigger."""

    output: int
    component: int
    frequency_hz: float
    amplitude_v: float
    phase_rad: float


@dataclass(frozen=True)
class BoardProgram:
    """Sequence and sines of one board.

    levels_v: (steps, channels) float32; enable: (steps, channels) uint8; channels 0 and 1 are the outputs, from 2 on
    the slow analog ones.
    """

    step_samples: int
    levels_v: NDArray[np.float32]
    enable: NDArray[np.uint8]
    sines: tuple[Sine, ...]

    @property
    def silent(self) -> bool:
        """There is nothing to play."""
        return not self.sines and not np.any(self.levels_v)

    @property
    def samples(self) -> int:
        """Samples after the trigger during which the sequence runs."""
        return 0 if self.silent else self.step_samples * len(self.levels_v)

    def same_steps(self, other: BoardProgram) -> bool:
        """Whether the tables of both are the same; their sines may differ."""
        if self is other:
            return True
        same = self.step_samples == other.step_samples and np.array_equal(self.levels_v, other.levels_v)
        return same and np.array_equal(self.enable, other.enable)


def compile_timeline(
    timeline: Timeline, layout: Layout, full_scale_v: float = OUTPUT_FULL_SCALE_V
) -> tuple[BoardProgram, ...]:
    """One program per board.  Raises SequenceRejected for whatever the boards cannot play exactly."""
    complaints = [*_clock_complaints(timeline, layout), *_pin_complaints(timeline, layout)]
    for output in sorted({b.output for b in timeline.bursts}):
        complaints += _output_complaints(timeline, output, layout, full_scale_v)
    step = _step(timeline, layout)
    if step is None:
        complaints.append(f"its edges do not all lie on multiples of {layout.step_samples} samples")
    if complaints or step is None:
        raise SequenceRejected(
            "the card cannot play this timeline",
            where="I/O card",
            why="; ".join(complaints),
            remedy="change the sequence, or the card's table in the platform file",
        )
    return tuple(_board_program(board, timeline, layout, step) for board in range(len(layout.boards)))


def _board_program(board: int, timeline: Timeline, layout: Layout, step: int) -> BoardProgram:
    """Gates, levels and sines of one board; a board with nothing to do has one silent step."""
    levels: list[tuple[int, int, int, float]] = []
    gates: list[tuple[int, int, int]] = []
    for line, pin in layout.lines.items():
        if pin.board == board and pin.sequence_channel is not None:
            channel = pin.sequence_channel
            levels += [(channel, e.start_sample, e.stop_sample, HIGH_V) for e in timeline.lines if e.line is line]
    for burst in timeline.bursts:
        where, output = layout.output(burst.output)
        if where == board:
            gates.append((output, burst.start_sample, burst.stop_sample))
            levels += [(output, burst.start_sample, burst.stop_sample, _level_v(burst))] if _is_level(burst) else []
    channels_used = [p.sequence_channel for p in layout.lines.values() if p.board == board]
    used = [*(c for c in channels_used if c is not None), *(output for output, _, _ in gates)]
    channels = 1 + max(used, default=0)  # the server takes 7 to 17 ms for each; beyond them all amplitudes are zero
    stops = [stop for _, _, stop, _ in levels] + [stop for _, _, stop in gates]
    steps = 1 + max(stops, default=0) // step
    levels_v = np.zeros((steps, channels), np.float32)
    enable = np.zeros((steps, channels), np.uint8)
    enable[:, FIRST_ANALOG_CHANNEL:] = 1
    for channel, start, stop, volts in levels:
        levels_v[start // step : stop // step, channel] = volts
    for output, start, stop in gates:
        enable[start // step : stop // step, output] = 1
    return BoardProgram(step, levels_v, enable, _sines(board, timeline, layout))


def _sines(board: int, timeline: Timeline, layout: Layout) -> tuple[Sine, ...]:
    """The sines of the first interval of each output of this board; those of all intervals are the same."""
    found = []
    for index in sorted({b.output for b in timeline.bursts}):
        where, output = layout.output(index)
        if where == board:
            parts = next(iter(_intervals(timeline, index).values()))
            for component, burst in enumerate(b for b in parts if not _is_level(b)):
                amplitude, phase = _from_trigger(burst, timeline)
                found.append(
                    Sine(
                        output=output,
                        component=component,
                        frequency_hz=burst.frequency_hz,
                        amplitude_v=amplitude,
                        phase_rad=phase,
                    )
                )
    return tuple(found)


def _is_level(burst: Burst) -> bool:
    """A constant, which the sequence holds, and no sine."""
    return burst.frequency_hz == 0


def _level_v(burst: Burst) -> float:
    return burst.amplitude_v * math.sin(burst.phase_rad)


def _from_trigger(burst: Burst, timeline: Timeline) -> tuple[float, float]:
    """Amplitude V >= 0 and phase rad in 0..2 pi, counted from the trigger."""
    turned = 2 * math.pi * math.fmod(burst.frequency_hz * burst.start_sample / timeline.clock.rate_hz, 1.0)
    sign = math.pi if burst.amplitude_v < 0 else 0.0
    return abs(burst.amplitude_v), (burst.phase_rad + sign - turned) % (2 * math.pi)


def _intervals(timeline: Timeline, output: int) -> dict[tuple[int, int], list[Burst]]:
    """The bursts of an output by their interval."""
    found: dict[tuple[int, int], list[Burst]] = {}
    for burst in sorted((b for b in timeline.bursts if b.output == output), key=lambda b: b.start_sample):
        found.setdefault((burst.start_sample, burst.stop_sample), []).append(burst)
    return found


def _output_complaints(timeline: Timeline, output: int, layout: Layout, full_scale_v: float) -> list[str]:
    """What keeps an output from playing its bursts: one gate, three sines that stay, or levels."""
    if not 0 <= output < layout.outputs:
        return [f"there is no output {output}"]
    complaints = []
    intervals = _intervals(timeline, output)
    ends = sorted(intervals)
    if any(later[0] < earlier[1] for earlier, later in pairwise(ends)):
        complaints.append(f"bursts of output {output} overlap without beginning and ending together")
    if all(_is_level(b) for bursts in intervals.values() for b in bursts):
        if any(len(bursts) > 1 for bursts in intervals.values()):
            complaints.append(f"output {output} holds one level at a time")
        peak_v = timeline.loudest_v(output)
        return (
            complaints
            if peak_v <= full_scale_v
            else [*complaints, f"output {output} would need {peak_v} V of {full_scale_v} V"]
        )
    groups = [[(b.frequency_hz, *_from_trigger(b, timeline)) for b in bursts] for bursts in intervals.values()]
    if len(groups[0]) > COMPONENTS:
        complaints.append(f"output {output} has {COMPONENTS} sines, not {len(groups[0])}")
    if any(not _same_sines(groups[0], other) for other in groups[1:]):
        complaints.append(f"bursts of output {output} are not one running sine that is gated")
    peak_v = max(sum(abs(b.amplitude_v) for b in bursts) for bursts in intervals.values())
    if not peak_v <= full_scale_v:
        complaints.append(f"output {output} would need {peak_v} V of {full_scale_v} V")
    highest_hz = layout.clock.rate_hz / 2
    for b in timeline.bursts:
        if b.output == output and not 0.03 <= b.frequency_hz < highest_hz:
            complaints.append(f"{b.frequency_hz} Hz is outside 0.03 ... {highest_hz} Hz")
    return complaints


def _same_sines(a: list[tuple[float, float, float]], b: list[tuple[float, float, float]]) -> bool:
    if len(a) != len(b):
        return False
    same = (
        p[0] == q[0] and p[1] == q[1] and abs(math.remainder(p[2] - q[2], 2 * math.pi)) < PHASE_TOLERANCE_RAD
        for p, q in zip(a, b, strict=True)
    )
    return all(same)


def _clock_complaints(timeline: Timeline, layout: Layout) -> list[str]:
    complaints = []
    if timeline.clock != layout.clock:
        complaints.append(f"its clock is {layout.clock}, not {timeline.clock}")
    if timeline.total_samples > MAX_SAMPLES:
        complaints.append(f"{timeline.total_samples} samples are more than {MAX_SAMPLES}")
    return complaints


def _pin_complaints(timeline: Timeline, layout: Layout) -> list[str]:
    """A line on a DIO pin is late by up to `pin_delay_s`; power and receiver must be apart by more than that."""
    delay = layout.line_delay_s() * layout.clock.rate_hz
    power = [e for e in timeline.lines if e.line is DigitalLine.PA_GATE]
    receive = [e for e in timeline.lines if e.line is DigitalLine.RX_CONNECT]
    close = any(p.start_sample < r.stop_sample + delay and r.start_sample < p.stop_sample + delay
                for p in power for r in receive)  # fmt: skip
    return [f"lines on DIO pins need {layout.pin_delay_s} s between gate and receiver"] if delay and close else []


def _step(timeline: Timeline, layout: Layout) -> int | None:
    """Samples per step: a multiple of the grid on which every edge lies; None if there is none."""
    timed = [e for e in timeline.lines if layout.lines[e.line].sequence_channel is not None]
    edges = [(b.start_sample, b.stop_sample) for b in timeline.bursts] + [
        (e.start_sample, e.stop_sample) for e in timed
    ]
    common = math.gcd(*(sample for pair in edges for sample in pair))
    if common == 0:
        return layout.step_samples
    if common % layout.step_samples:
        return None
    times = common // layout.step_samples
    most = max(1, LONGEST_STEP // layout.step_samples)
    return layout.step_samples * max(k for k in range(1, most + 1) if times % k == 0)
