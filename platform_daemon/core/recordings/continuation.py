"""Resuming a recording that has too few shots: its shots become single files again, as during the series."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from drivers.errors import InputError

from .assembly import header_of
from .header import SeriesHeader, ShotRecord
from .layout import FLAGS
from .reader import open_recording
from .recording import Recording
from .truth import read_truth


def check_continues(recording: Recording, header: SeriesHeader) -> None:
    """Are further shots under this header shots of the same series?  Raises InputError, RecordingError."""
    before = header_of(recording)[0]
    for what, old, new in (
        ("platform", before.platform, header.platform),
        ("receive calibration", _name(before), _name(header)),
        ("sampling clock", _clock(before), _clock(header)),
        ("windows", before.sequence, header.sequence),
        ("bearing", before.variant, header.variant),
        ("number of channels", before.channels, header.channels),
    ):
        if old != new:
            why = f"it was {old}, and is {new}"
            remedy = "measure the shots that are missing as a series of its own"
            raise InputError(f"the {what} has changed since", where=recording.path.name, why=why, remedy=remedy)


def shots_of(recording: Recording) -> Iterator[ShotRecord]:
    """Its shots as they were handed to the store, to the bit; one at a time in memory.  Raises RecordingError."""
    truths = read_truth(recording.path) or [{}] * recording.frames
    for k in range(recording.frames):
        yield _shot(recording, k, truths[k])


def _shot(recording: Recording, k: int, truth: dict[str, object]) -> ShotRecord:
    info = recording.frame_info[k]
    return ShotRecord(
        volts=recording.frame_volts(k)[:, : info.valid_samples],
        time_stamp=info.time_stamp or "",
        monotonic_s=0.0 if info.monotonic_s is None else info.monotonic_s,
        verdict=info.verdict,
        reason=info.reason,
        temperature_c=info.temperature_c,
        blank=info.blank,
        excitation=info.excitation,
        truth=truth or None,
        joined=info.joined,
        late_s=info.late_s,
        **{name: getattr(info, name) for name in FLAGS},
    )


def holds_all_of(shots: list[Path], target: Path) -> bool:
    """Are these the single files of the resumed recording `target`?  Raises RecordingError."""
    whole = open_recording(target)
    firsts = [open_recording(shot) for shot in shots]
    if header_of(whole)[1] != header_of(firsts[0])[1]:
        return False
    return {info.shot for info in whole.frame_info} <= {first.frame_info[0].shot for first in firsts}


def _name(header: SeriesHeader) -> str | None:
    return None if header.calibration is None else header.calibration.identifier


def _clock(header: SeriesHeader) -> tuple[float, int]:
    return header.sequence.base_frequency_hz, header.sequence.decimation
