"""Properties: what is written comes back, for any shape and any text; damage is always told, never a crash."""

from __future__ import annotations

import json
import math
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drivers.errors import RecordingError
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.header import ShotRecord
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import SequenceInfo
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.schemas.base import to_json
from tests.kit.recording_files import START, fit_table, header, shot, write_minimal, write_series

FINITE = st.floats(-10, 10, width=32)
TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**40), 2**40) | st.floats(allow_nan=False, allow_infinity=False) | TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXT, inner, max_size=3),
    max_leaves=8,
)


@st.composite
def series(draw: st.DrawFn) -> tuple[SequenceInfo, np.ndarray]:
    windows = draw(st.tuples(st.integers(0, 4), st.integers(0, 3), st.integers(1, 9)))
    shape = (draw(st.integers(1, 3)), draw(st.integers(1, 4)), sum(windows))
    sequence = SequenceInfo(draw(st.floats(1, 1e9)), draw(st.integers(1, 1 << 20)), *windows)
    return sequence, draw(arrays(np.float32, shape, elements=FINITE))


def test_names_in_the_truth_that_hdf5_cannot_hold_stay_in_its_json(tmp_path: Path) -> None:
    truth = {"": {"": False}, "a": {"": 1}, ".": 2, "b/c": 3, "ok": 4}
    with SeriesWriter.create(tmp_path / "t.h5", header()) as writer:
        writer.add_shot(shot(1, truth=truth))
        path = writer.finish()
    assert path is not None
    assert read_truth(path) == [truth]


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(series(), TEXT, TEXT, st.dictionaries(TEXT, JSON, max_size=3))
def test_any_series_comes_back_exactly(given_series, comment: str, reason: str, truth: dict) -> None:
    sequence, data = given_series
    frames, channels, _ = data.shape
    bare = header(
        sequence=sequence, channels=channels, calibration=None, channel_names=(), planned_shots=None, comment=comment
    )
    with tempfile.TemporaryDirectory() as folder:
        with SeriesWriter.create(Path(folder) / "a.h5", bare) as writer:
            for volts in data:
                writer.add_shot(ShotRecord(volts, START, 1.0, reason=reason, truth=truth))
            path = writer.finish()
        r = open_recording(path)
        assert r.sequence == sequence
        assert np.array_equal([r.frame_volts(k) for k in range(frames)], data)
        assert (r.provenance.comment, r.frame_info[0].reason) == (comment, reason)
        assert read_truth(path) == [truth] * frames
        to_json(describe(r))


@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from([np.float16, np.float32, np.float64, np.longdouble]),
    st.sampled_from([np.int8, np.uint8, np.int16, np.uint32, np.int64, np.float64]),
    st.tuples(st.integers(0, 3), st.integers(0, 3), st.integers(1, 9)),
    st.booleans(),
)
def test_any_width_from_elsewhere_is_read(wide, narrow, windows, compressed: bool) -> None:
    data = np.arange(2 * 3 * sum(windows), dtype=wide).reshape(2, 3, -1)
    sizes = dict(zip(("numTxSamples", "numSwitchSamples", "numRxSamples"), map(narrow, windows), strict=True))
    changes = {f"/sequence/{name}": size for name, size in sizes.items()} | {"/data": data}
    if compressed:
        changes["/data"] = lambda h5, name: h5.create_dataset(name, data=data, compression="lzf", fletcher32=True)
    with tempfile.TemporaryDirectory() as folder:
        r = open_recording(write_minimal(Path(folder) / "a.h5", changes))
        assert np.array_equal(r.frame_volts(1), data[1])


def _damaged(whole: bytes, rng: random.Random) -> bytes:
    kind = rng.randrange(4)
    if kind == 0:
        return whole[: rng.randrange(len(whole))]
    content = bytearray(whole)
    start = rng.randrange(len(whole))
    if kind == 1:
        content[start] ^= 1 << rng.randrange(8)
    elif kind == 2:
        content[start : start + 8] = rng.randbytes(8)
    else:
        content[start : start + rng.randrange(1, 400)] = bytes(rng.randrange(1, 400))
    return bytes(content)


READ_ALL = """
import json, sys
from pathlib import Path
from drivers.errors import RecordingError
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.reader import open_recording, read_calibration
from platform_daemon.core.schemas.base import to_json
from tests.kit.fit_tables import read_fits
from platform_daemon.core.recordings.truth import read_truth
def whole(path):
    r = open_recording(path)
    to_json(describe(r))
    for k in range(r.frames): r.frame_volts(k)
counts = {"read": 0, "refused": 0}
for path in sorted(Path(sys.argv[1]).iterdir()):
    print(path, file=sys.stderr)
    for read in (whole, read_calibration, read_fits, read_truth):
        try:
            read(path)
            counts["read"] += 1
        except RecordingError as error:
            assert error.where and "\\n" not in str(error)
            counts["refused"] += 1
print(json.dumps(counts))
"""


@pytest.mark.long
def test_any_damage_gives_a_valid_reading_or_a_recording_error(tmp_path: Path) -> None:
    rng = random.Random(7)
    originals = [
        write_minimal(tmp_path / "foreign.h5").read_bytes(),
        write_series(tmp_path / "own.h5", fits=(fit_table(3),)).read_bytes(),
    ]
    folder = tmp_path / "damaged"
    folder.mkdir()
    for k in range(200):
        (folder / f"{k:05d}.h5").write_bytes(_damaged(originals[k % 2], rng))
    # In a process of its own: if damage ever crashes libhdf5 itself, this test says which file did it.
    done = subprocess.run(
        [sys.executable, "-c", READ_ALL, str(folder)], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr[-2000:]
    counts = json.loads(done.stdout)
    assert counts["read"] + counts["refused"] == 4 * 200
    assert min(counts.values()) > 100


def test_truncation_at_every_tenth_of_a_file_is_told(tmp_path: Path) -> None:
    whole = write_series(tmp_path / "own.h5").read_bytes()
    for tenth in range(10):
        path = tmp_path / "cut.h5"
        path.write_bytes(whole[: math.ceil(len(whole) * tenth / 10)])
        with pytest.raises(RecordingError, match=re.escape(str(path))):
            open_recording(path)
