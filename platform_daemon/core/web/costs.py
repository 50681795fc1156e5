"""Bounds of what one request may make the server hold or compute.

A count says little: a window of 100 s holds 400 times the samples of one of 0.24 s.  So samples are counted, which is
what memory and time go by.  Measured on one core: 10^6 samples of three channels take 0.1 s and 70 MB to calibrate.
"""

from __future__ import annotations

from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.recordings.angle_series import is_time_series
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import Recording

MOST_FRAME_VALUES = 20_000_000
"""Of the frame that a request reads: samples times channels, 109 s of three channels at the usual rate."""
MOST_SENT_VALUES = 12_000_000
"""Of the part that is sent in full, 100 MB: the server holds it until the client has fetched it."""
MOST_SLIDING_FITS, MOST_SLIDING_SAMPLES = 500, 40_000_000
"""Fits of one request, and samples of all its windows together: some 20 s of a core."""


class TooCostly(InputError):
    """The request is valid, but would take more memory or time than one request may."""

    title = "Too costly"


def check_frame(recording: Recording) -> None:
    """Raises TooCostly for frames that are too long to be calibrated while a request waits."""
    values = recording.channels * recording.sequence.total
    if values > MOST_FRAME_VALUES:
        what = f"a frame of this recording has {values} values"
        why = f"a request reads at most {MOST_FRAME_VALUES}"
        remedy = "fetch the file (GET /recordings/{identifier}/file) and use the command line, or fit it as a job"
        raise TooCostly(what, where=recording.path.stem, why=why, remedy=remedy)


def check_file(path: Path) -> None:
    """The same check for a file that may hold angles.  Raises TooCostly, RecordingError."""
    if not is_time_series(path):
        check_frame(open_recording(path))
    elif (values := path.stat().st_size // 8) > MOST_FRAME_VALUES:
        what, why = f"this file has {values} values", f"a request reads at most {MOST_FRAME_VALUES}"
        raise TooCostly(what, where=path.stem, why=why, remedy="fit it as a job (POST /fits)")


def check_sent(values: int) -> None:
    """Raises TooCostly for a part that is too long to be sent in full."""
    if values > MOST_SENT_VALUES:
        what, why = f"this part has {values} values", f"at most {MOST_SENT_VALUES} are sent at once"
        remedy = "ask for a shorter part with start_s and stop_s, several times, or fetch the whole file"
        raise TooCostly(what, where="start_s, stop_s", why=why, remedy=remedy)
