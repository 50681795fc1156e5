"""All that is on disk: recordings, calibrations, angle files; read anyone's, write our own so that no acknowledged shot
is lost.

AngleSeries: A series of angles with an even clock.
is_time_series: Does the file hold /time and /signal instead of a recording? Raises RecordingError if it cannot be
    opened.
read_angles: Raises RecordingError naming file, HDF5 path, what was expected and a remedy.
AuditLog: The audit log.
TokenFile: Tokens by name.
has_expired: Is a token past its last moment?
audit_log_in: The audit log of a data folder, which a daemon may have open.
tokens_in: The tokens of a data folder, which a daemon may have open.
add_receive_calibration: A new version of a receive calibration, with what was measured.
add_transmit_calibration: A new version of a transmit calibration.
check_calibration_name: Raises InputError unless a file can be called so.
read_transmit_calibration: The transmit side in a calibration file or a recording.
DataFolder: Where a daemon keeps what it makes.
data_paths: Where everything is in a folder that another process has opened.
open_data_folder: The folders, made if missing.
is_data_folder: Has a daemon worked there?
describe: Summary of a recording.
dmdt_file: The bytes of a file with the data sets `quantity` (channel, time), `channel` (names) and `time` (s).
EventJournal: Takes events from any thread.
EventReader: Reads the journal that others write.
KeptEvent: An event as kept.
read_event: An event, typed.
Mark: A file without content, which says by being there.
sync: Have a file or folder on the disk.
write_file: `target` with `content`, whole or not at all, in the place of what was there.
write_new_file: The same, but never in the place of another file.
NotFinite: A sample is NaN or infinite.
check_room: Raises StorageUnusable where the disk cannot take a recording.
kept_series: Series whose shots are safe but were never put together.
read_fit: On-line fits as a recording keeps them.
IndexedPoint: Shots of one recording that were made within some minutes, in one.
IndexedRecording: What the index holds of a recording.
IndexedShot: A shot with a good fit.
IndexUpdate: What was looked at.
RecordingIndex: The index of the recordings.
open_index: That of a folder.
RetentionRules: Which old recordings may go.
delete: Delete them for good.
move_away: Move them into an archive.
named_in: Ids that the files of a folder name.
old_recordings: Those that may go.
recover_all: Put together every series whose writer died.
StorageError: The disk refused to keep data.
StoredFrame: Where a frame can be read.
read_frame: Something of a frame of a recording, or of a series that runs.
describe_running: What a series that runs holds so far.
UnknownRecording: No recording of that id exists in the folder.
FitTable: Fit results of a series under one window and model, one row per frame.
joined_fits: One table per window and model, each with a row for every frame; the rows of other steps are refused.
SeriesHeader: What holds for every shot of a series.
ShotRecord: One shot as it came from the hardware.
Broken: A file that looks like what is listed but is not usable, and why.
list_recordings: The recordings in `folder` (not below it).
recording_files: What may be a recording by its name and place.
resolve: The file of an id.
open_recording: Open and check a recording of docs/file-format.md.
read_calibration: The calibration in a recording or in a file that holds nothing but `/calibration`.
Excitation: What one shot was excited with.
FrameInfo: One frame's own record.
RESONATOR: Between the configuration of the platform and the declaration of the resonator.
Recording: A checked recording.
SequenceInfo: Sample clock and windows of every frame.
StepLabel: Which step of a procedure a shot belongs to.
SeriesWriter: Writes one series.
Wanted: Which recordings are looked for.
Version: One version of something.
unit_of: Unit of a number by its name.
VersionedFolder: The versions in a folder, which need not exist before the first is added.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
