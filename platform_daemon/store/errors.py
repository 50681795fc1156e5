"""Errors of the store that are not a defect inside one file.

PlatformError
├── StorageError                  the disk refused: full, read-only, unplugged; what was acknowledged stays safe
└── InputError
    └── UnknownRecording          no recording of that id in the folder (REST: 404)
"""

from __future__ import annotations

from drivers.errors import InputError, PlatformError


class StorageError(PlatformError):
    """The disk refused to keep data.  Acknowledged shots stay in the staging folder until `recover` finds them."""

    title = "Storage failed"


class UnknownRecording(InputError):
    """No recording of that id exists in the folder."""

    title = "Unknown recording"
