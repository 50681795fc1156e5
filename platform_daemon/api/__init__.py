"""REST over the owner of the hardware and the analysis.

AnalysisKeeper: Takes up analyses that wait.
Context: What every route needs.
EventTail: Follows the journal of events for all listeners.
Metrics: Numbers for Prometheus.
TrendKeeper: Brings the index of the recordings up to date, and raises alarms of changes.
certificate_of: The files of TLS, both or none.
rules: The rules for a server on an address.
too_many_previews: All processes that compute what requests wait for are busy.
served: An application on its socket, in a thread of its own.
create_api: The application over the owner of the hardware and the data folder.
create_stop_api: An application that can do nothing but stop, by the same rules.
"""

from .analysis_keeper import AnalysisKeeper
from .context import Context
from .event_tail import EventTail
from .metrics import Metrics
from .network.lanes import too_many_previews
from .network.listening import certificate_of, rules
from .network.served import served
from .server import create_api, create_stop_api
from .trend_keeper import TrendKeeper

__all__ = [
    "AnalysisKeeper",
    "Context",
    "EventTail",
    "Metrics",
    "TrendKeeper",
    "certificate_of",
    "create_api",
    "create_stop_api",
    "rules",
    "served",
    "too_many_previews",
]
