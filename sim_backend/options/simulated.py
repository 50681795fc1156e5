"""The whole table `[backends.simulated]`, the clock and the converters."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from drivers.specimen import Specimen
from drivers.validation import validated
from sim_backend.hidden_effects.listing import HiddenEffects
from sim_backend.hidden_effects.signals import check_distinct, extra_poles_hz
from sim_backend.section import Positive, Section

from .effects import EffectsOptions, FaultOptions, HousingOptions, ThermometerOptions
from .receive import LnaOptions, NoiseOptions, ReceiveOptions, SwitchOptions
from .transmit import AmplifierOptions, CoilsOptions, WiringOptions


class ClockOptions(Section):
    """World time.

    mode: in `fast`, world time advances only when a caller sleeps or reads samples; in `realtime` it follows the
    computer's clock, `speed` times as fast; start_utc: date and time at construction, None: this computer's.
    """

    mode: Literal["fast", "realtime"]
    speed: Positive = 1.0
    start_utc: datetime | None = None


class CardOptions(Section):
    """Converters of the card: peak full scales, V, and resolution of the ADC, bit."""

    input_full_scale_v: Positive
    output_full_scale_v: Positive
    adc_bits: Annotated[int, Field(ge=4, le=24)]


class _EffectsOfSpecimen(Section):
    """Their tables in a resonator's file."""

    undeclared: HiddenEffects


class SimulatedOptions(Section):
    """The whole table `[backends.simulated]`."""

    seed: Annotated[int, Field(ge=0)]
    clock: ClockOptions
    card: CardOptions
    amplifier: AmplifierOptions
    coils: CoilsOptions
    switch: SwitchOptions
    lna: LnaOptions
    receive: ReceiveOptions
    noise: NoiseOptions
    effects: EffectsOptions
    thermometer: ThermometerOptions
    housing: HousingOptions = HousingOptions()
    wiring: WiringOptions = WiringOptions()
    faults: FaultOptions = FaultOptions()
    hidden_effects: HiddenEffects = Field(default=(), alias="undeclared")

    def with_effects_of(self, specimen: Specimen) -> SimulatedOptions:
        """These options with the undeclared effects of a specimen added.  Raises ConfigError."""
        if not specimen.rotor.undeclared:
            return self
        where = f"resonator {specimen.name!r}, rotor"
        added = validated(_EffectsOfSpecimen, {"undeclared": list(specimen.rotor.undeclared)}, where).undeclared
        tables = self.model_dump(by_alias=True) | {"undeclared": (*self.hidden_effects, *added)}
        return validated(type(self), tables, where)

    @model_validator(mode="after")
    def _poles(self) -> Self:
        for channel, poles in enumerate(self.receive.in_place().poles_hz):
            check_distinct(poles + extra_poles_hz(self.hidden_effects, channel))
        return self
