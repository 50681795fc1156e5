"""Errors of the store other than a defect of a file (RecordingError).

PlatformError
├── StorageError                  the disk refused: full, read-only, unplugged; what was acknowledged stays safe
│   ├── StorageUnusable           found before anything moved
│   └── NotAssembled              shots are safe, the recording is not there yet
├── IndexUnfinished               the index is being made again (REST: 503)
└── InputError
    ├── UnknownRecording          no recording of that id in the folder (REST: 404)
    └── RecordingError
        ├── NotFinite             a sample is NaN or infinite
        ├── UnknownUnit           numbers in a unit that is unknown, or of another dimension
        ├── MissingFilter         the data are compressed in a way that this HDF5 library cannot undo
        └── RecordingNotNow       it cannot be read now, for a reason that may pass without a change of the file
            └── RecordingInUse        another program has the file open for writing (REST: 423)
                └── RecordingUnfinished   the file is cut off and has changed just now: it may still be written
"""

from __future__ import annotations

from drivers.errors import InputError, PlatformError, RecordingError


class StorageError(PlatformError):
    """The disk refused to keep data.  Acknowledged shots stay in the staging folder until `recover` finds them."""

    title = "Storage failed"
    http_status = 507


class StorageUnusable(StorageError):
    """The disk cannot take what is to be measured: too little room, read-only, or it does not keep what it is given.

    Found before anything moved.
    """

    title = "Storage unusable"
    nothing_moved = True


class IndexUnfinished(PlatformError):
    """What the index of the recordings holds is not all yet: it is being made from their files."""

    title = "Index unfinished"
    http_status = 503


class NotAssembled(StorageError):
    """Acknowledged shots are safe, each in a file of its own, but could not be put together to a recording."""

    title = "Recording not put together"


class UnknownRecording(InputError):
    """No recording of that id exists in the folder."""

    title = "Unknown recording"
    http_status = 404


class RecordingNotNow(RecordingError):
    """The file cannot be read now: no permission, a disk or network that fails.  It may be whole."""


class RecordingInUse(RecordingNotNow):
    """Another program has the file open for writing: it can be read later, and is not damaged."""

    title = "Recording in use"
    http_status = 423


class RecordingUnfinished(RecordingInUse):
    """The file ends too early and has changed seconds ago: it may still be written or copied."""

    title = "Recording unfinished"


class MissingFilter(RecordingError):
    """A dataset is compressed by a filter that this HDF5 library does not have: the file is whole."""

    title = "Missing filter of HDF5"


class UnknownUnit(RecordingError):
    """A dataset says that its numbers are in a unit that does not convert to the one that is needed."""

    title = "Unknown unit"


class NotFinite(RecordingError):
    """A sample is NaN or infinite."""

    title = "Samples are not finite"

    @property
    def seen(self) -> str:
        """What and where, in short."""
        return f"{self.what.removeprefix('not_finite: ')} at {self.where}"
