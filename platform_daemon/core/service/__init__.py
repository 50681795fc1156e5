"""The application service: one interface for CLI, REST, schedules and procedures, local or over a socket."""
