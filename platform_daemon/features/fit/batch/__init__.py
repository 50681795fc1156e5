"""Fits of many files: on all cores, on a cluster, with a ledger of finished files."""
