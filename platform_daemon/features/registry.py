"""The features of the daemon: one folder each, in the order in which the REST documentation shows them."""

FEATURES = (
    "acquire",
    "procedures",
    "sweep",
    "tune",
    "ramp",
    "schedules",
    "alarms",
    "calibrate",
    "self_test",
    "recordings",
    "trends",
    "fit",
    "budget",
    "measurand",
    "design",
    "diagnose",
    "characterise",
    "reproduce",
    "models",
    "page",
)
