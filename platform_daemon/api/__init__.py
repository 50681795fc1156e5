"""REST over the owner of the hardware and the analysis.

AnalysisKeeper: Takes up analyses that wait.
Certificate: What TLS is made with.
Context: What every route needs.
EventTail: Follows the journal of events for all listeners.
Metrics: Numbers for Prometheus.
Network: Rules of a server.
TrendKeeper: Brings the index of the recordings up to date, and raises alarms of changes.
certificate_of: The files of TLS, both or none.
rules: The rules for a server on an address.
too_many_previews: All processes that compute what requests wait for are busy.
served: An application on its socket, in a thread of its own.
create_api: The application over the owner of the hardware and the data folder.
create_stop_api: An application that can do nothing but stop, by the same rules.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
