"""Models that a diagnosis has made better: named, versioned, never overwritten, with the evidence for them.

adopted_model.py (what is adopted) - adoption.py (from a diagnosis, or refused) - library.py (on disk) - resolve.py
(names wherever a variant is accepted) - evidence.py (from which data).
"""
