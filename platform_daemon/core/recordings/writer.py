"""Writes the layout of docs/reference/file-format.md: a shot as the bytes of a file, or the frame of a series."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from typing import Any

import h5py
import numpy as np

from drivers.calibration import MeasuredInfluence, ReceiveCalibration, TransmitCalibration

from .datasets import clean, group, put, put_texts
from .header import SeriesHeader, ShotRecord
from .layout import (
    CALIBRATION,
    DATA,
    ENTRY,
    EXCITATION,
    FLAGS,
    FRAMES,
    FREQUENCY,
    FREQUENCY_RESPONSE,
    INFLUENCES,
    LAYOUT,
    LAYOUT_ATTRIBUTE,
    RING_DOWN,
    SENSITIVITY,
    SEQUENCE,
    TRANSMIT,
)
from .recording import Excitation, FrameInfo, FrameStep
from .steps import write_steps
from .truth import write_truth
from .validate import check_excitation, check_instant, padded_volts
from .value_sources import write_value_sources

LIBVER = ("v108", "v108")
"""HDF5 1.8 format: every reader since 2008 opens it, and its metadata carry checksums, which the older one lacks."""

SIXTEEN_BIT = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
"""Measured on 16-bit volts: 30-38 % of the size at 0.13 s per 11 MB; level 4 gains 1 % for twice the time."""


def shot_file(header: SeriesHeader, series_id: str, number: int, shot: ShotRecord) -> bytes:
    """A complete one-frame recording, as the bytes of its file.  Raises InputError if the shot does not fit.

    Built in memory, so that a full disk is an OSError of one write and never an HDF5 library in an undefined state.
    """
    volts, valid = padded_volts(header, shot)
    info = frame_info(header, number, shot, valid)
    with h5py.File("shot", "w", driver="core", backing_store=False, libver=LIBVER) as h5:
        create_data(h5, 1, *volts.shape)[0] = volts
        write_metadata(h5, header, series_id, [info])
        write_truth(h5, [shot.truth])
        link_plot(h5, header, [info], with_time=False)
        h5.flush()
        return bytes(h5.id.get_file_image())


def empty_file() -> bytes:
    """An HDF5 file without content, as the bytes of it."""
    with h5py.File("empty", "w", driver="core", backing_store=False, libver=LIBVER) as h5:
        h5.flush()
        return bytes(h5.id.get_file_image())


def frame_info(header: SeriesHeader, number: int, shot: ShotRecord, valid_samples: int) -> FrameInfo:
    """The record of a shot as the reader will give it back.  Raises InputError for a wrong time or excitation."""
    check_instant(shot.time_stamp, "time_stamp")
    excitation = shot.excitation or header.excitation
    if excitation is not None:
        check_excitation(excitation)
        if shot.blank and shot.excitation is None:
            excitation = replace(excitation, field_t=0.0, current_a=np.zeros_like(excitation.current_a))
    flags = {name: bool(getattr(shot, name)) for name in (*FLAGS, "blank")}
    s = header.sequence
    windows = s.tx_samples, s.switch_samples, s.rx_samples
    return FrameInfo(
        shot=number,
        valid_samples=valid_samples,
        verdict=shot.verdict,
        reason=shot.reason,
        time_stamp=shot.time_stamp,
        monotonic_s=shot.monotonic_s,
        temperature_c=shot.temperature_c,
        excitation=excitation,
        step=None if shot.step is None else FrameStep(shot.step, *windows),
        joined=shot.joined,
        late_s=shot.late_s,
        **flags,
    )


def create_data(h5: h5py.File, frames: int, channels: int, samples: int) -> h5py.Dataset:
    """The empty `/data`: one chunk per frame and channel, so that reading a frame decompresses nothing else."""
    data = h5.create_dataset(
        DATA, (frames, channels, samples), np.float32, chunks=(1, 1, samples), track_times=False, **SIXTEEN_BIT
    )
    data.attrs.update({"units": "V", "long_name": "voltage at the ADC input", "interpretation": "spectrum"})
    return data


def write_metadata(h5: h5py.File, header: SeriesHeader, series_id: str, infos: Sequence[FrameInfo]) -> None:
    """Everything but volts, truth, plot and fits."""
    h5.attrs.update({"NX_class": "NXroot", "default": "entry", LAYOUT_ATTRIBUTE: LAYOUT})
    h5.attrs.update({"creator": "platform-daemon", "creator_version": clean(header.software_version)})
    _write_sequence(h5, header, len(infos))
    if header.calibration is not None:
        write_calibration_group(h5, header.calibration)
    if header.variant is not None:
        put(group(h5, "resonator", "NXcollection"), "variant", header.variant)
    _write_frames(h5, infos)
    _write_excitation(h5, [info.excitation for info in infos])
    write_steps(h5, [info.step for info in infos])
    _write_entry(h5, header, series_id, infos)
    write_value_sources(h5, header.value_sources, None if infos[-1].step is None else infos[-1].step.label.number)


def write_calibration_group(h5: h5py.File, calibration: ReceiveCalibration) -> None:
    """`/calibration`, in a recording or in a file of its own."""
    group(h5, CALIBRATION, "NXcollection")
    put(h5, SENSITIVITY, np.asarray(calibration.sensitivity, np.float64), units="T/A")
    if calibration.frequency_hz is not None:
        put(h5, FREQUENCY, np.asarray(calibration.frequency_hz, np.float64), units="Hz")
        put(h5, FREQUENCY_RESPONSE, np.asarray(calibration.frequency_response, np.complex128), units="1")
    for name, value, units in (
        ("identifier", calibration.identifier, None),
        ("date", calibration.date, None),
        ("lna_gain", calibration.lna_gain, "V/V"),
    ):
        if value is not None:
            put(h5, f"{CALIBRATION}/{name}", value, units=units)
    if calibration.sensitivity_std is not None:
        put(h5, f"{CALIBRATION}/sensitivity_std", np.asarray(calibration.sensitivity_std, np.float64), units="T/A")
    if calibration.p_std is not None:
        said = "of the real and of the imaginary part of P, (channel, axis, frequency)"
        put(h5, f"{CALIBRATION}/p_std", np.asarray(calibration.p_std, np.float64), units="T/A", long_name=said)
    if calibration.relative_std is not None:
        put(h5, f"{CALIBRATION}/relative_std", calibration.relative_std, units="1")
    _write_extent(h5, CALIBRATION, calibration)
    if calibration.influences:
        _write_influences(h5, calibration.influences)
    if calibration.transmit is not None:
        write_transmit_group(h5, calibration.transmit)


def _write_influences(h5: h5py.File, influences: tuple[MeasuredInfluence, ...]) -> None:
    """`/calibration/uncertainty`: a column for each of their attributes."""
    made = group(h5, INFLUENCES, "NXcollection")
    put_texts(made, "influence", [each.name for each in influences])
    said = "standard uncertainty, relative or rad"
    put(made, "u", np.array([each.u for each in influences]), units="1", long_name=said)
    put_texts(made, "type", [each.kind for each in influences])
    freedom = np.array([math.inf if each.dof is None else each.dof for each in influences])
    put(made, "dof", freedom, units="1", long_name="degrees of freedom of u")
    put_texts(made, "source", [each.source for each in influences])


def write_transmit_group(h5: h5py.File, table: TransmitCalibration) -> None:
    """`/calibration/transmit`, in a recording or in a file of its own."""
    if CALIBRATION not in h5:
        group(h5, CALIBRATION, "NXcollection")
    made = group(h5, TRANSMIT, "NXcollection")
    put_texts(made, "axes", table.axes)
    put(made, "identifier", table.identifier)
    put(made, "date", table.date)
    for name, values, units in (
        ("frequency", table.frequency_hz, "Hz"),
        ("field_per_volt", table.field_per_volt, "T/V"),
        ("field_per_volt_std", table.field_per_volt_std, "T/V"),
        ("field_per_ampere", table.field_per_ampere_t, "T/A"),
        ("inductance", table.inductance_h, "H"),
    ):
        put(made, name, values, units=units)
    _write_extent(h5, TRANSMIT, table)


def _write_extent(h5: h5py.File, where: str, made: ReceiveCalibration | TransmitCalibration) -> None:
    """What a calibration holds for, as far as it says."""
    for name, value, units in (
        ("valid_frequency", made.valid_hz, "Hz"),
        ("valid_temperature", made.valid_c, "degC"),
        ("temperature", made.temperature_c, "degC"),
    ):
        if value is not None:
            put(h5, f"{where}/{name}", np.asarray(value, np.float64), units=units)


def link_plot(h5: h5py.File, header: SeriesHeader, infos: Sequence[FrameInfo], with_time: bool) -> None:
    """The default plot: `/data` by a second hard link, with its axes.

    A shot file goes without the time axis: 1 to 7 MB that its neighbours would repeat.
    """
    plot = group(h5, RING_DOWN, "NXdata")
    plot["volts"] = h5[DATA]
    put(plot, "frame", np.arange(len(infos)), units="1", long_name="frame, from 0; its shot is in /frames/shot")
    put(plot, "channel", np.arange(header.channels), units="1", long_name="receive channel")
    plot.attrs.update({"signal": "volts", "axes": ["frame", "channel", "time" if with_time else "."]})
    if with_time:
        s = header.sequence
        time = (np.arange(s.total) - s.rx_start) / s.rate_hz
        put(plot, "time", time, units="s", long_name="time since the first RX sample", **SIXTEEN_BIT)


def _write_sequence(h5: h5py.File, header: SeriesHeader, frames: int) -> None:
    s = header.sequence
    made = group(h5, SEQUENCE, "NXcollection")
    put(made, "baseFrequency", np.float64(s.base_frequency_hz), units="Hz")
    put(made, "decimation", np.int64(s.decimation), units="1")
    put(made, "numFrames", np.int64(frames), units="1")
    for name, count in (("Tx", s.tx_samples), ("Switch", s.switch_samples), ("Rx", s.rx_samples)):
        put(made, f"num{name}Samples", np.int64(count), units="samples")


def _write_frames(h5: h5py.File, infos: Sequence[FrameInfo]) -> None:
    made = group(h5, FRAMES, "NXcollection")
    put(made, "shot", np.array([i.shot for i in infos]), units="1")
    put(made, "valid_samples", np.array([i.valid_samples for i in infos]), units="samples")
    put(made, "monotonic", _or_nan(i.monotonic_s for i in infos), units="s")
    put(made, "temperature", _or_nan(i.temperature_c for i in infos), units="degC")
    for name in (*FLAGS, "blank"):
        # uint8, not bool: h5py's bool is an HDF5 enumeration that Julia and MATLAB do not read as one.
        put(made, name, np.array([getattr(i, name) for i in infos], np.uint8), units="1")
    if any(i.joined for i in infos):
        put(made, "joined", np.array([i.joined for i in infos], np.uint8), units="1")
    if any(i.late_s is not None for i in infos):
        put(made, "late", _or_nan(i.late_s for i in infos), units="s")
    put_texts(made, "time_stamp", (i.time_stamp or "" for i in infos))
    put_texts(made, "verdict", (i.verdict for i in infos))
    put_texts(made, "reason", (i.reason for i in infos))


def _write_excitation(h5: h5py.File, excitations: Sequence[Excitation | None]) -> None:
    outputs = next((len(e.current_a) for e in excitations if e is not None), None)
    if outputs is None:
        return
    nan, axis, current = math.nan, np.full(3, math.nan), np.full(outputs, math.nan)
    unknown = Excitation("", nan, nan, nan, axis, nan, nan, current)
    rows = [unknown if e is None else e for e in excitations]
    made = group(h5, EXCITATION, "NXcollection")
    put_texts(made, "waveform", (e.waveform for e in rows))
    for name, source, units in (
        ("requested_frequency", "requested_hz", "Hz"),
        ("realised_frequency", "realised_hz", "Hz"),
        ("field", "field_t", "T"),
        ("periods", "periods", "1"),
        ("phase", "phase_rad", "rad"),
        ("axis", "axis", "1"),
        ("current", "current_a", "A"),
    ):
        put(made, name, np.array([getattr(e, source) for e in rows], np.float64), units=units)


def _write_entry(h5: h5py.File, header: SeriesHeader, series_id: str, infos: Sequence[FrameInfo]) -> None:
    entry = group(h5, ENTRY, "NXentry")
    entry.attrs["default"] = "ring_down"
    put(entry, "title", header.title or f"{header.variant or 'MMR'} ring-down series")
    put(entry, "entry_identifier", series_id)
    put(entry, "start_time", header.start_time)
    if header.clock is not None:
        put(entry, "clock", header.clock)
    put(entry, "end_time", _end_of(infos[-1], header))
    put(entry, "program_name", "platform-daemon")
    put(entry, "program_version", header.software_version)
    put(entry, "platform", header.platform)
    put_texts(entry, "channel_names", header.channel_names)
    if header.planned_shots is not None:
        put(entry, "planned_shots", np.int64(header.planned_shots), units="1")
    sample = group(entry, "sample", "NXsample")
    put(sample, "name", header.sample_name)
    sample["temperature"] = h5[f"{FRAMES}/temperature"]
    put(group(entry, "operator", "NXuser"), "name", header.operator)
    _note(entry, "comment", "text/plain", header.comment)
    _note(entry, "configuration", "application/toml", header.configuration_toml)
    devices = group(entry, "devices", "NXcollection")
    put_texts(devices, "role", header.devices.keys())
    put_texts(devices, "identity", header.devices.values())


def _end_of(last: FrameInfo, header: SeriesHeader) -> str:
    """The end of its last sample, ISO 8601; of its trigger if it ends after all dates."""
    s = last.step or header.sequence
    samples = s.tx_samples + s.switch_samples + s.rx_samples
    begun = last.time_stamp or header.start_time
    with contextlib.suppress(OverflowError, ValueError):  # of a damaged shot the rest is worth keeping
        return (datetime.fromisoformat(begun) + timedelta(seconds=samples / header.sequence.rate_hz)).isoformat()
    return begun


def _note(entry: h5py.Group, name: str, kind: str, text: str) -> None:
    note = group(entry, name, "NXnote")
    put(note, "type", kind)
    put(note, "data", text)


def _or_nan(values: Iterable[float | None]) -> Any:
    # HDF5 has no null; NaN stands for "not measured" in these two columns, and only there.
    return np.array([np.nan if v is None else v for v in values], np.float64)
