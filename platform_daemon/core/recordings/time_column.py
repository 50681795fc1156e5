"""The time column of a series: its longest even stretch, the holes in it, and what makes it no time column at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Times = NDArray[np.float64]
_UNEVEN = 0.25  # of a step: a step that differs more is a gap
_RATE = 16  # uneven steps in a row that are alike: no hole, but another sampling rate
_ALIKE = 0.8  # of them
_LISTED = 4  # gaps that are listed one by one
_SWAPPED = (
    16  # samples: stamps that are off by at most so many places are in disorder, and those further off, another run
)

_STRETCH = 8  # samples of the mean ordered stretch in shuffled rows; shorter ones may be of two clocks in turn


def order_of(time_s: Times) -> tuple[NDArray[np.intp], str] | None:
    """(order that sorts samples with shuffled stamps, what was done in words); None: there is nothing to sort.

    Shuffled are samples of which each has a stamp of its own and that are in order but for a few places, as a phone
    writes them, or in no order at all, or whose stretches fit together without a hole.  A clock that starts again or
    counts down is not.
    """
    backwards = np.count_nonzero(np.diff(time_s) < 0.0)
    if not backwards or not np.isfinite(time_s).all():
        return None
    order = np.argsort(time_s, kind="stable")
    moved = np.abs(order - np.arange(time_s.size))
    in_no_order = time_s.size / 4 < backwards < 0.9 * time_s.size
    steps = np.diff(time_s[order])
    usual = float(np.median(steps))
    seams = steps[np.diff(order) != 1]
    fit_together = seams.max() < (1.0 + _UNEVEN) * usual and seams.size * _STRETCH < time_s.size
    if not (in_no_order or moved.max() <= _SWAPPED or fit_together) or steps.min() < (1.0 - _UNEVEN) * usual:
        return None
    return order, f"the times of {np.count_nonzero(moved)} samples were out of order; the samples were sorted by time"


def fault_of(time_s: Times) -> tuple[str, str] | None:
    """(what is wrong with a time column, n >= 2, and a remedy); None: time runs on, at one rate but for holes."""
    steps = np.diff(time_s)
    back, still = np.flatnonzero(steps < 0.0), np.flatnonzero(steps == 0.0)
    if back.size:
        k = int(back[0])
        what = f"runs back from {time_s[k]:.7g} s to {time_s[k + 1]:.7g} s at sample {k + 1}{_more(back.size)}"
        return what, "write every run of the clock to a file of its own"
    if still.size:
        k = int(still[0])
        what = f"repeats: sample {k + 1} has the time of the sample before it, {time_s[k]:.7g} s{_more(still.size)}"
        return what, "give every sample a time of its own, or leave repeated samples out"
    return _other_rate(time_s, steps)


def _more(count: int) -> str:
    return f", and {count - 1} more times" if count > 1 else ""


def _other_rate(time_s: Times, steps: Times) -> tuple[str, str] | None:
    """The longest run of steps that are alike and not the usual ones."""
    usual = float(np.median(steps))
    uneven = np.concatenate([[False], np.abs(steps - usual) > _UNEVEN * usual, [False]])
    edges = np.flatnonzero(np.diff(uneven.astype(np.int8)))
    runs = [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= _RATE]
    for first, last in sorted(runs, key=lambda run: run[0] - run[1]):
        other = float(np.median(steps[first:last]))
        if np.mean(np.abs(steps[first:last] - other) <= _UNEVEN * other) > _ALIKE:
            what = (
                f"mixes sampling rates: {1.0 / usual:.5g} Hz, but {1.0 / other:.5g} Hz from sample {first} "
                f"at {time_s[first]:.6g} s to sample {last}"
            )
            return what, "write the samples of each rate to a file of their own"
    return None


def even_stretch(time_s: Times) -> tuple[int, int, tuple[str, ...]]:
    """(first, last + 1 sample of the longest stretch without a hole, the gaps in words)."""
    steps = np.diff(time_s)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(np.abs(steps - usual) > _UNEVEN * usual)
    ends = np.concatenate([[-1], gaps, [time_s.size - 1]])
    longest = int(np.argmax(np.diff(ends)))
    first, last = int(ends[longest]) + 1, int(ends[longest + 1]) + 1
    return first, last, _gaps_in_words(steps / usual, gaps, first, last)


def _gaps_in_words(steps: Times, gaps: NDArray[np.int64], first: int, last: int) -> tuple[str, ...]:
    """steps: (n - 1,) in units of the usual one."""
    if not gaps.size:
        return ()
    used = f"only samples {first} to {last - 1}, the longest even stretch, are used"
    remarks = [f"the time column goes on by {steps[g]:.4g} steps before sample {g + 1}; {used}" for g in gaps[:_LISTED]]
    more = gaps.size - _LISTED
    return (*remarks, f"and {more} further uneven steps in the time column") if more > 0 else tuple(remarks)
