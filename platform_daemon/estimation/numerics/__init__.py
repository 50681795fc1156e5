"""What every other part computes with: compilation, small linear algebra, Chebyshev grids.

arrays: Array types used throughout: float64 unless a docstring says otherwise.
blas_threads: A fit runs on one core.
chebyshev: Chebyshev grids: nodes in [-1, 1], the way from values to coefficients, and exact integration matrices.
finite_differences: Time derivatives of sampled channels.
jit: Compilation of the numerical kernels: lazy, cached, released from the GIL.
linear_systems: Small linear systems, compiled: where a call of LAPACK would cost more than the work.
"""
