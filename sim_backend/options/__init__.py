"""Configuration of the simulated platform: the table `[backends.simulated]` and the small tables of its devices.

config/platforms/simulated.toml is a complete example with comments.  Every key is required unless its class gives a
default.

simulated.py   the whole table, its clock and its converters
transmit.py    amplifier, coils, wiring
receive.py     switch, LNA, receive chain, noise
effects.py     variations from shot to shot, the thermometer, and the shots at which faults occur
tables.py      the tables of single devices in a platform file
"""

from .effects import EffectsOptions, FaultOptions, HousingOptions, TemperatureEffect
from .receive import ChainOptions, ColourOptions, HumOptions, SwitchOptions
from .simulated import ClockOptions, SimulatedOptions
from .tables import CalibrationTable, DipoleTable, EmptyTable, IoCardTable, LnaTable, ProbeTable
from .transmit import AmplifierOptions, CoilOptions, CoilsOptions, WiringOptions

__all__ = [
    "AmplifierOptions",
    "CalibrationTable",
    "ChainOptions",
    "ClockOptions",
    "CoilOptions",
    "CoilsOptions",
    "ColourOptions",
    "DipoleTable",
    "EffectsOptions",
    "EmptyTable",
    "FaultOptions",
    "HousingOptions",
    "HumOptions",
    "IoCardTable",
    "LnaTable",
    "ProbeTable",
    "SimulatedOptions",
    "SwitchOptions",
    "TemperatureEffect",
    "WiringOptions",
]
