"""The daemon: acquisition, calibrated dm/dt, on-line fitting, by REST and on the command line."""

from importlib.metadata import version

__version__ = version("platform-daemon")
