"""What a fit leaves over, and what follows: warnings, other models, refusals, the verdict."""
