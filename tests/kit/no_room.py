"""A disk that refuses, in the place of `write_file`."""

from platform_daemon.store import StorageError


def no_room(path, content):
    """Never writes."""
    raise StorageError("the disk is full")
