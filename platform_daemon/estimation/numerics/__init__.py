"""What every other part computes with: compilation, small linear algebra, Chebyshev grids."""
