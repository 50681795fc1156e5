"""Recording a series so that nothing acknowledged is lost: shot by shot on disk, one file at the end."""

from __future__ import annotations

import secrets
import stat
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType

from drivers.errors import InputError
from platform_daemon.core.state.disk_space import check_free_space
from platform_daemon.core.state.durable import write_file
from platform_daemon.core.state.errors import StorageError

from .assembly import assemble, header_of
from .continuation import check_continues, shots_of
from .header import FitTable, SeriesHeader, ShotRecord
from .leftovers import not_assembled
from .reader import open_recording
from .recovery import recover_series
from .staging import Staging, busy, claim, claim_abandoned, folder_of
from .validate import check_fit, check_header
from .writer import shot_file


class SeriesWriter:
    """Writes one series.  Used by one thread; as a context manager it gives its lock free on leaving.

    Leaving without `finish` (an exception, a kill) keeps the acknowledged shots for `recover`.
    """

    def __init__(self, target: Path, header: SeriesHeader, overwrite: bool, staging: Staging) -> None:
        self.target, self.header = target, header
        self.series_id = secrets.token_hex(16)
        self._overwrite, self._staging = overwrite, staging
        self._shots, self._outputs = 0, _outputs(header.excitation)

    @classmethod
    def create(
        cls, target: Path | str, header: SeriesHeader, overwrite: bool = False, most_bytes: int | None = None
    ) -> SeriesWriter:
        """Begin a series that will appear as `target`; until then `target` is not touched.

        most_bytes: of all samples, None: as planned shots like the first are.

        Shots that a crash left behind for the same target are recovered to a file of their own first.  Raises
        InputError: target exists (unless `overwrite`), is a directory or in use, its folder is missing or not
        writable, or the header is wrong; StorageUnusable: the disk cannot take the planned shots.
        """
        target = Path(target).absolute()
        check_header(header)
        _check_target(target, overwrite)
        if folder_of(target).is_dir():
            _recover_left(target, spare_target=overwrite)
            _check_target(target, overwrite)
        _check_space(target, header, most_bytes)
        return cls(target, header, overwrite, claim(target))

    @classmethod
    def go_on(cls, target: Path, header: SeriesHeader) -> SeriesWriter:
        """Go on with a recording that has too few shots, with shots of the same kind; or begin it if it is not there.

        It stays as it is until `finish` puts all in its place.  Raises as `create`, InputError if platform,
        calibration, windows or bearing are others, RecordingError, StorageError.
        """
        if not target.exists():
            return cls.create(target, header)
        check_header(header)
        before = open_recording(target)
        check_continues(before, header)
        made = cls(target, header_of(before)[0], True, _claimed(target))
        try:
            made.series_id = header_of(before)[1]
            for shot in shots_of(before):
                made.add_shot(shot)
        except BaseException:
            made.drop()
            raise
        made.go_on_with(replace(header, start_time=made.header.start_time))
        return made

    def drop(self) -> None:
        """What is in single files is not wanted; call only where it is safe in `target`."""
        self._staging.remove()

    @property
    def shots(self) -> int:
        """Number of acknowledged shots."""
        return self._shots

    @property
    def frames(self) -> int:
        """Frames that the recording has by now."""
        return self._shots

    @property
    def last_shot(self) -> Path:
        """The file of the last acknowledged shot, a recording of its own until the series is put together."""
        return self._staging.shot_file(self._shots)

    def shot_file(self, number: int) -> Path:
        """The recording of an acknowledged shot, from 1; it is there until the series is finished."""
        return self._staging.shot_file(number)

    def add_shot(self, shot: ShotRecord) -> int:
        """Write one shot and return its number, from 1.  When this returns, the shot survives a power failure.

        Raises InputError if the shot does not fit the header, StorageError if the disk refuses; the shot is not
        recorded then, and the series can continue.
        """
        self._check_outputs(shot)
        number = self._shots + 1
        write_file(self._staging.shot_file(number), shot_file(self.header, self.series_id, number, shot))
        self._shots = number
        return number

    def go_on_with(self, header: SeriesHeader) -> None:
        """Further shots are those of another step, whose header may differ in windows, excitation and texts.

        Raises InputError if the header is wrong, or not of the same clock, channels and bearing.
        """
        check_header(header)
        for what, mine, other in (
            ("sampling clock", _clock(self.header), _clock(header)),
            ("number of channels", self.header.channels, header.channels),
            ("bearing", self.header.variant, header.variant),
        ):
            if mine != other:
                remedy = "measure it as a series of its own"
                raise InputError(f"the {what} differs within one recording", where="recording", remedy=remedy)
        self.header = header

    def finish(self, fits: Sequence[FitTable] = (), incomplete: str | None = None) -> Path | None:
        """Put the series file together, remove the staging folder, return the file.

        incomplete: why there are fewer shots than planned, "": there are not, None: as the number of shots says.

        A series without a single shot leaves nothing behind and returns None.  Raises InputError (a fit table of the
        wrong size; a target that someone else created meanwhile) or NotAssembled; the shots stay safe then, and
        `finish` may be called again.
        """
        for fit in fits:
            check_fit(fit, self._shots)
        if self._shots == 0:
            self._staging.remove()
            return None
        _check_target(self.target, self._overwrite)
        shots = [self._staging.shot_file(number) for number in range(1, self._shots + 1)]
        try:
            assemble(shots, self._staging.part, self.target, fits=fits, incomplete=incomplete)
        except StorageError as error:
            raise not_assembled(self._staging.folder, self._shots, error.why) from error
        self._staging.remove()
        return self.target

    def close(self) -> None:
        """Let go without finishing: the shots stay for `recover`.  Idempotent, also after `finish`."""
        if self._shots == 0 and not self._staging.lock.closed:
            self._staging.remove()
        self._staging.release()

    def __enter__(self) -> SeriesWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _check_outputs(self, shot: ShotRecord) -> None:
        # All shots share one (frame, outputs) table in the series file; a misfit must not surface at the end.
        found = _outputs(shot.excitation)
        self._outputs = found if self._outputs is None else self._outputs
        if found not in (None, self._outputs):
            what = f"excitation.current_a has {found} outputs, the series {self._outputs}"
            raise InputError(what, where="recording", remedy="give one current per output of the platform")


def _claimed(target: Path) -> Staging:
    """A staging folder for a recording that exists; what a crash has left there is put together first."""
    if folder_of(target).is_dir():
        _recover_left(target)
    return claim(target)


def _recover_left(target: Path, *, spare_target: bool = False) -> None:
    """Raises InputError if another process fills it, StorageError."""
    left = claim_abandoned(folder_of(target))
    if left is None:
        raise busy(target)
    try:
        recover_series(left, spare_target=spare_target)
    finally:
        left.release()


def _clock(header: SeriesHeader) -> tuple[float, int]:
    return header.sequence.base_frequency_hz, header.sequence.decimation


def _outputs(excitation: object) -> int | None:
    current = getattr(excitation, "current_a", None)
    return None if current is None else len(current)


def _check_target(target: Path, overwrite: bool) -> None:
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        raise InputError(f"cannot record here: {error}", where=str(target), remedy="choose another path") from None
    if stat.S_ISDIR(mode):
        raise InputError("is a directory", where=str(target), remedy="name a file, for example thread.h5")
    if not overwrite:
        remedy = "choose another name, or overwrite on purpose (--force)"
        raise InputError("the file exists already", where=str(target), remedy=remedy)


def _check_space(target: Path, header: SeriesHeader, most_bytes: int | None) -> None:
    if header.planned_shots is None or not target.parent.is_dir():
        return
    # Twice: the shot files and the series file exist together for a moment.  Compression is not counted on.
    most_bytes = most_bytes or header.planned_shots * header.channels * header.sequence.total * 4
    check_free_space(target.parent, most_bytes, header.planned_shots)
