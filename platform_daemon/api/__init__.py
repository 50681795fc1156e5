"""REST over the engine and the analysis.

Context: Engine, folders of recordings, fit results and diagnoses, adopted models, folder of calibrations, and what
    has warmed up.
Server: Outputs off comes first in the signal path.
create_api: The application over an engine and its folders.
create_stop_api: An application that can do nothing but stop, by the same rules.
certificate_of: The files of TLS, both or none.
rules: The rules for a server on an address.
stop_server: POST /stop on a port and in a thread of its own.
"""

from .context import Context
from .network.listening import certificate_of, rules
from .network.stop_server import stop_server
from .server import Server, create_api, create_stop_api

__all__ = [
    "Context",
    "Server",
    "certificate_of",
    "create_api",
    "create_stop_api",
    "rules",
    "stop_server",
]
