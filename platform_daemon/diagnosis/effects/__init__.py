"""The library of effects that a diagnosis can name, one module per kind."""
