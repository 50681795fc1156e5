"""Samples and status records of a pipelined read.

After every chunk of samples (int16 little-endian pairs IN1, IN2) the server sends a record of 21 bytes: status bits,
how far the reader lags behind the recording, how much was recorded while sending, and four figures of the output side.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from drivers.errors import ShotRefused
from drivers.io_card import ChunkFlags

RECORD = struct.Struct("<BQQ4B")
PAIR_BYTES = 4
RING_SAMPLES = 2**25
LONGEST_RECORDING = 2**40  # samples: 200 days
FIR_TAPS = 92
CIC_ORDER = 6
START_TIMES = 5
STATUS_LAG = 512  # samples: the status is read that much later than the write pointer, if the server is busy


def filter_delay_samples(decimation: int) -> float:
    """Delay of the decimation filters, CIC of order 6 to half the decimation and a FIR that halves it once more."""
    cic = (decimation / 2 - 1) / 2 * CIC_ORDER / decimation
    return cic + (FIR_TAPS - 1) / 2 / 2


def cic_gain(decimation: int) -> float:
    """Gain of the first filter, which the card does not take off; 1 for powers of two."""
    rate = decimation / 2
    return float(rate**CIC_ORDER / 2 ** math.ceil(CIC_ORDER * math.log2(rate)))


@dataclass(frozen=True)
class Record:
    """A chunk's record, with the write pointer when its sending began and what was recorded until it had ended
    (samples since the trigger); the status is that after the sending."""

    status: int
    written: int
    lag: int
    meanwhile: int

    @classmethod
    def parse(cls, raw: bytes | memoryview, first_sample: int) -> Record:
        """From its 21 bytes; `first_sample` is the raw index of the chunk's first sample."""
        status, lag, meanwhile, *_ = RECORD.unpack(raw)
        return cls(status, first_sample + lag, lag, meanwhile)

    @property
    def plausible(self) -> bool:
        """False for numbers that no recording reaches: bytes of the stream are missing, or these are samples."""
        return max(self.lag, self.meanwhile) < LONGEST_RECORDING

    @property
    def flags(self) -> ChunkFlags:
        """The card's flags; a reader that lags by a whole ring has read other samples, whether flagged or not."""
        s = self.status
        return ChunkFlags(bool(s & 1) or self.lag > RING_SAMPLES, bool(s & 2), bool(s & 4))

    @property
    def triggered(self) -> bool:
        """The master trigger was on."""
        return bool(self.status & 8)

    @property
    def playing(self) -> bool:
        """The output sequence was running."""
        return bool(self.status & 16)


class Continuity:
    """Checks from the status records, in addition to the card's flags, that one board made one whole recording.

    start_samples: how late after the trigger the server may report that the sequence plays.  A thread of the server
    notices it while the card plays already, so a busy server gets START_TIMES as long, at most to the sequence's end.
    """

    def __init__(self, where: str, sequence_samples: int, start_samples: int = 0) -> None:
        self._where = where
        self._sequence_samples = sequence_samples
        self._start_samples = start_samples
        self._written = 0
        self._played = False
        self._late = False

    def check(self, record: Record) -> None:
        """Raises ShotRefused if trigger, sequence or write pointer show that it is another recording."""
        if not record.plausible:
            raise ShotRefused(
                "a status record makes no sense", where=self._where, why="bytes of the stream are missing"
            )
        if not record.triggered:
            raise ShotRefused("the trigger fell during the shot", where=self._where)
        if record.written < self._written:
            raise ShotRefused(
                "the recording restarted during the shot",
                where=self._where,
                why=f"its write pointer went from {self._written} back to {record.written}",
            )
        self._played |= record.playing
        if not record.playing:
            self._check_stopped(record)
        self._written = record.written

    def _check_stopped(self, record: Record) -> None:
        """Check a record during which the sequence did not play: it has not begun, has ended, or ended too early.

        Sample numbers: the server had written `begun` before the record, and `ended` at most once it was sent.  The
        status may lag by STATUS_LAG samples.  `_played`: an earlier record saw the sequence play; `_late`: one saw that
        it had not begun in time.  Raises ShotRefused.
        """
        begun = record.written
        ended = record.written + record.meanwhile + STATUS_LAG
        over = ended >= self._sequence_samples
        if over and not (self._late and not self._played):
            return
        if self._played:
            raise ShotRefused(
                "the outputs ended early",
                where=self._where,
                why=f"the sequence stopped before sample {ended} of {self._sequence_samples}",
            )
        self._late |= begun > self._start_samples
        if over or begun > START_TIMES * self._start_samples:
            raise ShotRefused(
                "the outputs have not started",
                where=self._where,
                why=f"the server did not see its sequence begin within {begun} samples after the trigger",
            )
