"""What a card of several boards can do, by its table and its memory."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.io_card import CardCapabilities
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.layout import Layout
from drivers.red_pitaya.options import CardTable
from drivers.red_pitaya.scale import Scale
from drivers.red_pitaya.sequence import MAX_SAMPLES, OUTPUT_FULL_SCALE_V
from drivers.red_pitaya.sines import AMPLITUDE_STEP_V

FREQUENCY_STEP_HZ = 125e6 / 2**48
GRANULE = 32  # the recording grows in steps of so many samples


def card_capabilities(boards: Sequence[Board], table: CardTable, layout: Layout, delay: int) -> CardCapabilities:
    """See IoCard.capabilities; delay: samples by which a recording begins late, because of the card's filters."""
    pairs = list(zip(boards, layout.boards, strict=True))
    return CardCapabilities(
        inputs=layout.inputs,
        outputs=layout.outputs,
        input_full_scale_v=min(b.scale.full_scale_v(k) for b, where in pairs for k in where.inputs),
        output_full_scale_v=output_full_scale_v(boards, layout),
        clock=layout.clock,
        max_samples=MAX_SAMPLES - delay - GRANULE,
        step_samples=layout.step_samples,
        line_delay_s=layout.line_delay_s(),
        output_step_v=AMPLITUDE_STEP_V / min(_scales(_used(boards, layout))),
        frequency_step_hz=FREQUENCY_STEP_HZ,
        holds_levels=True,
        unproved_lines=layout.unproved_lines() if table.prove_wiring else (),
        input_ends_v=tuple(b.scale.ends_v(k) for b, where in pairs for k in where.inputs),
    )


def output_full_scale_v(boards: Sequence[Board], layout: Layout) -> float:
    """What every output can give, V: the server refuses more than full scale after its calibration."""
    used = _used(boards, layout)
    limits_v = [scale.output_limit_v[k] for scale, k in used]
    return min(OUTPUT_FULL_SCALE_V, OUTPUT_FULL_SCALE_V / max(_scales(used)), *limits_v)


def _used(boards: Sequence[Board], layout: Layout) -> list[tuple[Scale, int]]:
    """Each used output: what its board's memory says, and its number there."""
    return [(b.scale, k) for b, where in zip(boards, layout.boards, strict=True) for k in where.outputs]


def _scales(used: Sequence[tuple[Scale, int]]) -> list[float]:
    return [scale.output[k] for scale, k in used] or [1.0]
