"""Sets of candidates with what a linear step in them would gain, the best first."""

from __future__ import annotations

import itertools

import numpy as np

from ..regression.score_test import CandidateBlock, ScoreResult, ScoreTable

_PAIRS_FROM = 12  # blocks, for pairs with more than two columns
_NARROW_PAIRS = 80
_TOLD_APART = 1e-6  # share of two columns' power that must differ
_TRIPLES_FROM = 12  # pairs
_THIRDS_FROM = 24

Sets = list[tuple[list[CandidateBlock], ScoreResult]]


def singles(seen: ScoreTable) -> Sets:
    """Every candidate by itself."""
    scores = [([b], seen.gain([b])) for b in seen.blocks]
    found = [(b, s) for b, s in scores if s is not None]
    return sorted(found, key=lambda pair: -pair[1].gain)


def pairs(seen: ScoreTable) -> Sets:
    """The best pairs; of single columns all are looked at, because two effects can hide each other."""
    some = [blocks[0] for blocks, _ in singles(seen)][:_PAIRS_FROM]
    wide = [(a, b) for a, b in itertools.combinations(some, 2) if len(a.where) + len(b.where) > 2]
    offered = [(a, b) for a, b in [*_best_narrow_pairs(seen), *wide] if _compatible(a, b)]
    scores = [([a, b], seen.gain([a, b])) for a, b in offered]
    found = [(b, s) for b, s in scores if s is not None]
    return sorted(found, key=lambda pair: -pair[1].gain)


def _best_narrow_pairs(seen: ScoreTable) -> list[tuple[CandidateBlock, CandidateBlock]]:
    """Pairs of blocks of one column each that promise most, by the formula for two columns."""
    blocks = [b for b in seen.blocks if len(b.where) == 1]
    information, gradient = seen.beside_accepted([b.where[0] for b in blocks])
    power = np.diag(information)
    gained = gradient**2 * power[:, None] + gradient[:, None] ** 2 * power
    gained -= 2.0 * information * np.outer(gradient, gradient)
    left = np.outer(power, power) - information**2
    apart = left > _TOLD_APART * np.outer(power, power)
    promise = np.divide(gained, left, out=np.zeros_like(left), where=apart)
    rows, columns = np.triu_indices(len(blocks), 1)
    best = np.argsort(-promise[rows, columns])[:_NARROW_PAIRS]
    return [(blocks[rows[k]], blocks[columns[k]]) for k in best]


def triples(seen: ScoreTable) -> Sets:
    """The best pairs, each with a third."""
    thirds = [blocks[0] for blocks, _ in singles(seen)][:_THIRDS_FROM]
    found = []
    for pair, _ in pairs(seen)[:_TRIPLES_FROM]:
        for third in thirds:
            if all(third is not b and _compatible(third, b) for b in pair):
                score = seen.gain([*pair, third])
                if score is not None:
                    found.append(([*pair, third], score))
    return sorted(found, key=lambda item: -item[1].gain)


def _compatible(a: CandidateBlock, b: CandidateBlock) -> bool:
    """False for two scales of one effect, which are one effect."""
    if a.candidate.effect is not b.candidate.effect:
        return True
    scaled = a.candidate.hidden or a.candidate.detail.tau_s is not None
    return not scaled and not set(a.where) & set(b.where)
