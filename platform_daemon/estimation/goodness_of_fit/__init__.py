"""What a fit leaves over, and what follows: warnings, rivals, refusals, the verdict."""
