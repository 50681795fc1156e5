"""The model's basis at chosen places, from the tables of half cycles that a pass over the samples has left behind."""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.numerics.jit import fast_kernel
from platform_daemon.estimation.physics.trajectory.half_cycle_chain import HEAD, HEAD_DURATION, HEAD_SIDE, HEAD_START
from platform_daemon.estimation.physics.trajectory.half_cycle_table import look_up_values

from .tabulated import write_basis


@fast_kernel
def fill_basis_from_table(  # type: ignore[no-untyped-def]
    begin, dt, w, theta, done, count, heads, weights, symmetric, observable, nodes, values, out
):
    """Basis (basis_functions.py) at samples begin, begin + 1, ... into out (b, n).

    heads, weights: the next `count` half cycles as walk_half_cycles leaves them; values (2, k, f, m) of their tables.
    Returns the places written so far; `done` were before.
    """
    columns = (heads.shape[1] - HEAD) // 2
    m = nodes.size
    b = out.shape[0]
    here = np.empty((4 + 2 * columns, m))
    basis = np.empty((b - 1, m))
    by_node = np.empty(m)
    # Barycentric weights of Chebyshev nodes of the first kind, which are in their order (Berrut and Trefethen 2004).
    barycentric = np.sqrt(1.0 - nodes * nodes)
    barycentric[1::2] *= -1.0
    for half_cycle in range(count):
        ready = False
        while done < out.shape[1]:
            place = begin + done
            x = 2.0 * (w * dt * place + theta - heads[half_cycle, HEAD_START]) / heads[half_cycle, HEAD_DURATION] - 1.0
            if x >= 1.0:
                break
            if not ready:
                which = 0 if symmetric or heads[half_cycle, HEAD_SIDE] > 0.0 else 1
                look_up_values(weights[half_cycle], values[which], here)
                write_basis(here, heads[half_cycle], observable, nodes, w, theta, columns, 0, basis)
                ready = True
            whole = 0.0
            at_node = -1
            for i in range(m):
                apart = x - nodes[i]
                if apart == 0.0:
                    at_node = i
                    apart = 1.0
                by_node[i] = barycentric[i] / apart
                whole += by_node[i]
            if at_node >= 0:
                by_node.fill(0.0)
                by_node[at_node] = whole = 1.0
            for f in range(b - 1):
                total = 0.0
                for i in range(m):
                    total += basis[f, i] * by_node[i]
                out[f, done] = total / whole
            out[b - 1, done] = 1.0
            done += 1
    return done
