"""A disk that refuses, in the place of `Database.transaction`."""

from platform_daemon.core.state.errors import StorageError


def no_room(database):
    """Never begins a transaction."""
    raise StorageError("the disk is full")
