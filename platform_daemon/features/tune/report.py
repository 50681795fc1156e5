"""What tuning has found, for the terminal."""

from __future__ import annotations

import math

from platform_daemon.core.reporting.numbers import number
from platform_daemon.core.schemas.text import counted

from .schema import TuneOutcome


def outcome_text(found: TuneOutcome) -> str:
    """What tune has found, a line each; nothing where it has found nothing."""
    if found.f_nat_hz is None or found.sequence is None:
        return f"not tuned after {counted(found.shots, 'shot')}; the search began at {found.design_f_nat_hz:.5g} Hz"
    found_f, keys = found.f_nat_hz, found.sequence
    lines = [
        f"f_nat {number(found_f.value, found_f.std)} Hz in {counted(found.shots, 'shot')}, "
        f"begun at {found.design_f_nat_hz:.5g} Hz",
        f"f_TX {keys.f_tx_hz:g} Hz, {keys.tx_periods} periods, {1e6 * (keys.field_t or 0):.4g} uT: "
        f"about {math.degrees(found.swing_rad or 0):.3g} deg",
        f"listen for {keys.rx_s:g} s (30 % are left after {found.d30_s:.3g} s), pause {keys.pause_s:g} s",
        *(f"at a limit: {text}" for text in found.at_limits or ()),
        "not kept" if found.preset is None else f"kept as preset {found.preset}",
    ]
    return "\n".join(lines)
