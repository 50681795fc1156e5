"""Errors of the store beside a defect of a file (RecordingError).

PlatformError
├── StorageError                  the disk refused: full, read-only, unplugged; what was acknowledged stays safe
│   ├── StorageUnusable           found before anything moved
│   └── NotAssembled              shots are safe, the recording is not there yet
├── IndexUnfinished               the index is being made anew (REST: 503)
└── InputError
    ├── UnknownRecording          no recording of that id in the folder (REST: 404)
    └── RecordingError
        └── NotFinite             a sample is NaN or infinite
"""

from __future__ import annotations

from drivers.errors import InputError, PlatformError, RecordingError


class StorageError(PlatformError):
    """The disk refused to keep data.  Acknowledged shots stay in the staging folder until `recover` finds them."""

    title = "Storage failed"


class StorageUnusable(StorageError):
    """The disk cannot take what is to be measured: too little room, read-only, or it does not keep what it is given.

    Found before anything moved.
    """

    title = "Storage unusable"
    nothing_moved = True


class IndexUnfinished(PlatformError):
    """What the index of the recordings holds is not all yet: it is being made from their files."""

    title = "Index unfinished"


class NotAssembled(StorageError):
    """Acknowledged shots are safe, each in a file of its own, but could not be put together to a recording."""

    title = "Recording not put together"


class UnknownRecording(InputError):
    """No recording of that id exists in the folder."""

    title = "Unknown recording"


class NotFinite(RecordingError):
    """A sample is NaN or infinite."""

    title = "Samples are not finite"

    @property
    def seen(self) -> str:
        """What and where, in short."""
        return f"{self.what.removeprefix('not_finite: ')} at {self.where}"
