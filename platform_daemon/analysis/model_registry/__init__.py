"""Models that a diagnosis has made better: named, versioned, never overwritten, with the evidence for them.

adopted_model.py (what is adopted) - adoption.py (from a diagnosis, or refused) - library.py (on disk) - resolve.py
(names wherever a model is accepted, and what it corrects in the samples before a fit) - evidence.py (from which
data).
"""
