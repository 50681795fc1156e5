"""Recordings on disk: read anyone's, write our own so that no acknowledged shot is ever lost (docs/file-format.md)."""

from platform_daemon.store.calibration_extras import read_transmit_calibration
from platform_daemon.store.calibrations import (
    add_receive_calibration,
    add_transmit_calibration,
    check_calibration_name,
)
from platform_daemon.store.describe import describe
from platform_daemon.store.errors import NotFinite, StorageError, UnknownRecording
from platform_daemon.store.fits import read_fits
from platform_daemon.store.header import FitTable, SeriesHeader, ShotRecord
from platform_daemon.store.index import Broken, Entry, Listing, list_recordings, resolve
from platform_daemon.store.reader import open_recording, read_calibration
from platform_daemon.store.recording import (
    Calibration,
    Excitation,
    FrameInfo,
    Provenance,
    ReceiverEffect,
    Recording,
    SequenceInfo,
)
from platform_daemon.store.recovery import recover
from platform_daemon.store.series import SeriesWriter
from platform_daemon.store.truth import read_truth

__all__ = [
    "Broken",
    "Calibration",
    "Entry",
    "Excitation",
    "FitTable",
    "FrameInfo",
    "Listing",
    "NotFinite",
    "Provenance",
    "ReceiverEffect",
    "Recording",
    "SequenceInfo",
    "SeriesHeader",
    "SeriesWriter",
    "ShotRecord",
    "StorageError",
    "UnknownRecording",
    "add_receive_calibration",
    "add_transmit_calibration",
    "check_calibration_name",
    "describe",
    "list_recordings",
    "open_recording",
    "read_calibration",
    "read_fits",
    "read_transmit_calibration",
    "read_truth",
    "recover",
    "resolve",
]
