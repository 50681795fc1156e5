"""Recordings on disk: read anyone's, write our own so that no acknowledged shot is ever lost (docs/file-format.md)."""

from .calibrations import (
    add_receive_calibration,
    add_transmit_calibration,
    check_calibration_name,
    read_transmit_calibration,
)
from .describe import describe
from .errors import NotFinite, StorageError, UnknownRecording
from .fit_tables import read_fits
from .header import FitTable, SeriesHeader, ShotRecord
from .index import Broken, Entry, Listing, list_recordings, resolve
from .reader import open_recording, read_calibration
from .recording import Excitation, FrameInfo, Provenance, Recording, SequenceInfo
from .recovery import recover
from .series_writer import SeriesWriter
from .truth import read_truth

__all__ = [
    "Broken",
    "Entry",
    "Excitation",
    "FitTable",
    "FrameInfo",
    "Listing",
    "NotFinite",
    "Provenance",
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
