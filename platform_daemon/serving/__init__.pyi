from .daemon import Daemon as Daemon
from .logs import log_from as log_from
from .network import listen as listen
from .network import listen_for_stop as listen_for_stop
from .options import ServeOptions as ServeOptions
