"""The daemon as processes: a parent, one that owns the hardware, one that serves the web, one that stops.

Daemon: Starts them, starts anew what dies or hangs, and ends all in order.
log_from: Log events of at least a level, one per line, on stderr.
listen: A socket that listens.
listen_for_stop: A socket for the port that does nothing but stop.
ServeOptions: What a daemon is asked to be.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
