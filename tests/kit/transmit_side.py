"""A transmit side for tests: three orthogonal coils with resistance and inductance."""

import numpy as np

from drivers.calibration import TransmitChannel
from drivers.io_card import CardCapabilities
from drivers.timeline import SampleClock
from drivers.tx_rx_switch import SwitchTiming
from sequences.compiler import TransmitSide
from sequences.limits import SafetyLimits

CLOCK = SampleClock(125e6, 2048)


def channel(index: int, field_t: float = 1e-3) -> TransmitChannel:
    direction = np.eye(3)[index]
    return TransmitChannel("xyz"[index], index, 20.0, 60.0, 4.0, 1e-3, field_t * direction)


def side(**limits: float) -> TransmitSide:
    envelope = {"max_field_t": 1e-3, "max_coil_current_a": 2.0, "max_tx_s": 0.2, "max_tx_duty": 0.1} | limits
    return TransmitSide(
        channels=tuple(channel(k) for k in range(3)),
        card=CardCapabilities(
            inputs=3, outputs=3, input_full_scale_v=1.0, output_full_scale_v=1.0, clock=CLOCK, max_samples=2_000_000
        ),
        switch=SwitchTiming(dead_time_s=0.005, bounce_s=0.001, settle_s=0.002),
        limits=SafetyLimits(**envelope),
    )
