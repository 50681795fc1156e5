"""REST over the engine and the analysis.

Context: Engine, folders of recordings, fit results and diagnoses, adopted models, folder of calibrations, and what
    has warmed up.
Server: Outputs off comes first in the signal path.
create_api: The application over an engine and its folders.
"""

from .context import Context
from .server import Server, create_api

__all__ = [
    "Context",
    "Server",
    "create_api",
]
