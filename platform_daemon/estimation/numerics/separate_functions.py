"""Torque terms that are compiled by themselves: kernels call them by their address in memory.

The address is data of a kernel, as the number of any other term is. So a new term compiles its own few lines, and the
kernels in numba's cache stay valid.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numba
from llvmlite import ir  # type: ignore[import-untyped]
from numba.core.ccallback import CFunc
from numba.extending import intrinsic, overload

from .jit import separate_digest

types: Any = numba.types  # whose stubs lack most types
TermFunction = Callable[..., tuple[float, ...]]
_POINTER = types.CPointer(types.float64)
_ARGUMENTS = (*(types.float64,) * 5, _POINTER, types.intp, _POINTER)
_VECTOR = types.Array(types.float64, 1, "C")
# By address, for plain Python. The callbacks are kept too, because their machine code lives no longer than they do.
_FUNCTIONS: dict[int, tuple[TermFunction, Any]] = {}


@cache
def address_of(function: TermFunction, results: int) -> int:
    """Address of a function that returns so many numbers, compiled now or loaded from numba's cache.

    function: (phi, sin_phi, cos_phi, v, sigma or u, c, j, grad), as in torque_term.py, without a decorator.
    The address is valid in this process only.
    """
    returned = types.UniTuple(types.float64, results)
    callback: Any = CFunc(function, (_ARGUMENTS, returned), locals={}, options={"error_model": "numpy"})
    callback.enable_caching()
    cache_file = callback._cache._cache_file  # noqa: SLF001 numba has no public way to set the stamp
    cache_file._source_stamp = separate_digest(function)  # noqa: SLF001 as above
    callback.compile()
    address = int(callback.address)
    _FUNCTIONS[address] = function, callback
    return address


def call_autonomous(address, phi, sin_phi, cos_phi, v, sigma, c, j, grad):  # type: ignore[no-untyped-def]
    """(tau, d tau/d phi, d tau/d v) of the autonomous term at this address."""
    return _FUNCTIONS[int(address)][0](phi, sin_phi, cos_phi, v, sigma, c, j, grad)


def call_timed(address, phi, sin_phi, cos_phi, v, u, c, j, grad):  # type: ignore[no-untyped-def]
    """(tau, d tau/d phi, d tau/d v, d tau/d u) of the timed term at this address."""
    return _FUNCTIONS[int(address)][0](phi, sin_phi, cos_phi, v, u, c, j, grad)


def _call_in_kernels(function: TermFunction, results: int) -> None:
    """Compiled code takes `function` for a call of the address."""
    returned = types.UniTuple(types.float64, results)

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        address, *numbers, c, j, grad = arguments
        c_pointer, grad_pointer = (context.make_array(_VECTOR)(context, builder, x).data for x in (c, grad))
        kind = ir.FunctionType(context.get_value_type(returned), [context.get_value_type(a) for a in _ARGUMENTS])
        callee = builder.inttoptr(address, ir.PointerType(kind))
        return builder.call(callee, [*numbers, c_pointer, j, grad_pointer])

    @intrinsic
    def call(_typing, address, phi, sin_phi, cos_phi, v, moment, c, j, grad):  # type: ignore[no-untyped-def]
        return returned(types.intp, *(types.float64,) * 5, _VECTOR, types.intp, _VECTOR), generate

    @overload(function, strict=False)  # whose names of arguments differ
    def _compiled(address, phi, sin_phi, cos_phi, v, moment, c, j, grad):  # type: ignore[no-untyped-def]
        return lambda address, phi, sin_phi, cos_phi, v, moment, c, j, grad: call(  # noqa: PLW0108 numba wants one
            address, phi, sin_phi, cos_phi, v, moment, c, j, grad
        )


_call_in_kernels(call_autonomous, 3)
_call_in_kernels(call_timed, 4)
