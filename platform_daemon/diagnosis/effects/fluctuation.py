"""What fluctuates along the ring-down: a random process that is new in every shot."""

from __future__ import annotations

from .effect import Effect

FRICTION_FLUCTUATION = Effect(
    id="friction_fluctuation",
    unit="1",
    sign=1,
    separates=(),
    signature="the losses change within a ring-down, and otherwise in every shot",
    source="roughness of the contact, particles in it",
    absorbed="of a friction that fluctuates, T_f/I is the mean, which long or many ring-downs tell better",
)
FREQUENCY_FLUCTUATION = Effect(
    id="frequency_fluctuation",
    unit="Hz",
    sign=1,
    separates=(),
    signature="the frequency changes within a ring-down, and otherwise in every shot, while the losses do not",
    source="a contact that wanders in its cup, and with it the distance of the magnets; fields from outside",
    absorbed="of a frequency that fluctuates, f_nat is the mean, which long or many ring-downs tell better",
)
