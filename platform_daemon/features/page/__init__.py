"""Page: the operator's page, static files that a browser runs over the REST interface."""

from platform_daemon.core.registry import Feature

FEATURE = Feature(routes=(".routes",))
