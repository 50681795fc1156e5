"""One stretch of a pass over the samples, compiled as a whole: tables, the half swings they hold, their moments."""

from __future__ import annotations

import math

from .jit import fast_kernel
from .moments import collect_swings
from .swing_chain import STATUS_NO_TABLE, WALK_ANGLE, walk_swings
from .swing_table import build_table
from .trace import STATUS_LOST


@fast_kernel
def pass_stretch(  # type: ignore[no-untyped-def]
    low, high, settled, observable, columns, codes, widths, c, mirrored, walk, s_end, nodes, to_nodes, once, twice,
    barycentric, bands, sizes, accelerations, values, ends, heads, weights, y, first, last, dt, w, theta, skipped,
    stride, gram, products, energy,
):  # fmt: skip
    """Tabulate half swings of sizes low .. high (build_table), pass them (walk_swings), add their samples' moments
    (collect_swings); the tables are by direction. Returns (half swings, status, samples that took part).
    """
    side = -math.copysign(1.0, walk[WALK_ANGLE])
    which = 0 if mirrored or side > 0.0 else 1
    pull = build_table(
        low, high, 1.0 if mirrored else side, columns, codes, widths, c, observable, settled, nodes, once, twice,
        sizes[which], accelerations[which], values[which], ends[which],
    )  # fmt: skip
    bands[which, 0] = low
    bands[which, 1] = high
    bands[which, 2] = pull
    count, status = walk_swings(
        walk, s_end, columns, codes, widths, c, mirrored, bands, sizes, barycentric, ends, heads, weights
    )
    # Where there is no turning point, it may rest.
    if status == STATUS_NO_TABLE and math.isnan(pull):
        status = STATUS_LOST
    used = 0
    if count > 0 and last > first:
        used = collect_swings(
            y, first, last, dt, w, theta, skipped, stride, count, heads, weights, mirrored, observable, nodes,
            to_nodes, values, gram, products, energy,
        )  # fmt: skip
    return count, status, used
