"""Recordings of many shots by the independent generator: a file from elsewhere, of which every truth is known."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tests.kit.recording_files import SEQUENCE, P, write_minimal
from tests.kit.ring_down_generator import NOISE_SD, Truth, dmdt, with_noise

JEWEL = Truth(f_nat_hz=213.2, m_r_am2=0.012, tf_over_i_rad_per_s2=1200.0, phi_max_rad=0.93, psi_start_rad=3.8)
"""Like the paper's (tab:model_params_fit_result)."""


def jewels(count: int, seed: int = 5) -> list[Truth]:
    """So many shots of one jewel: its frequency, friction and start differ from shot to shot, its start phase lies
    around zero, and it turns a little."""
    random = np.random.default_rng(seed)
    return [
        JEWEL.with_(
            f_nat_hz=213.2 + 0.1 * random.standard_normal(),
            tf_over_i_rad_per_s2=1200.0 + 100.0 * random.standard_normal(),
            psi_start_rad=(0.03 * random.standard_normal()) % (2.0 * np.pi),
            rodrigues=tuple(np.array(JEWEL.rodrigues) + 1e-3 * random.standard_normal(3)),
        )
        for _ in range(count)
    ]


def write_ring_downs(
    target: Path, truths: Sequence[Truth | None], seconds: float = 1.2, variant: str = "jewel", **changes: Any
) -> Path:
    """A frame per truth, with the paper's noise; None: noise alone.  changes: of the file's entries by path."""
    random = np.random.default_rng(17)
    samples = round(seconds * SEQUENCE.rate_hz)
    frames = []
    for truth in truths:
        signal = np.zeros((3, samples)) if truth is None else dmdt(truth, seconds)
        rx = -P @ with_noise(signal, random, NOISE_SD)
        frames.append(np.concatenate([np.zeros((3, SEQUENCE.tx_samples + SEQUENCE.switch_samples)), rx], axis=1))
    known = {"/data": np.stack(frames), "/sequence/numRxSamples": samples, "/resonator/variant": variant}
    return write_minimal(target, {**known, **changes})
