"""The daemon as processes: parent, hardware process, web process, stop process."""
