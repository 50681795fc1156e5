"""What the simulated platform can be told: the table `[backends.simulated]` and the small tables of its devices.

config/platforms/simulated.toml is the commented original.  Every key is required unless a default stands in the class.

simulated.py   the whole table, its clock and its converters
transmit.py    amplifier, coils, wiring
receive.py     switch, LNA, receive chain, noise
effects.py     what changes from shot to shot, the thermometer, the shots at which something goes wrong
tables.py      the tables of single devices in a platform file
"""

from .effects import EffectsOptions, FaultOptions, TemperatureEffect
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
    "HumOptions",
    "IoCardTable",
    "LnaTable",
    "ProbeTable",
    "SimulatedOptions",
    "SwitchOptions",
    "TemperatureEffect",
    "WiringOptions",
]
