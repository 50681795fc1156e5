"""Sets of candidates with what a linear step in them would gain, the best first."""

from __future__ import annotations

import itertools

import numpy as np

from platform_daemon.diagnosis.regression.score_test import CandidateBlock, ScoreResult, ScoreTable
from platform_daemon.diagnosis.thresholds import THRESHOLDS

_LIMITS = THRESHOLDS.selection


Sets = list[tuple[list[CandidateBlock], ScoreResult]]


def singles(table: ScoreTable) -> Sets:
    """Every candidate by itself."""
    scores = [([b], table.gain([b])) for b in table.blocks]
    found = [(b, s) for b, s in scores if s is not None]
    return sorted(found, key=lambda pair: -pair[1].gain)


def pairs(table: ScoreTable) -> Sets:
    """The best pairs; those of single columns are all scored, because two effects can hide each other."""
    some = [blocks[0] for blocks, _ in singles(table)][: _LIMITS.wide_pairs_from]
    wide = [(a, b) for a, b in itertools.combinations(some, 2) if len(a.where) + len(b.where) > 2]
    offered = [(a, b) for a, b in [*_best_narrow_pairs(table), *wide] if _compatible(a, b)]
    scores = [([a, b], table.gain([a, b])) for a, b in offered]
    found = [(b, s) for b, s in scores if s is not None]
    return sorted(found, key=lambda pair: -pair[1].gain)


def _best_narrow_pairs(table: ScoreTable) -> list[tuple[CandidateBlock, CandidateBlock]]:
    """Pairs of blocks of one column each that promise most, by the formula for two columns."""
    blocks = [b for b in table.blocks if len(b.where) == 1]
    information, gradient = table.schur_complement([b.where[0] for b in blocks])
    power = np.diag(information)
    gained = gradient**2 * power[:, None] + gradient[:, None] ** 2 * power
    gained -= 2.0 * information * np.outer(gradient, gradient)
    left = np.outer(power, power) - information**2
    apart = left > _LIMITS.pair_power_share * np.outer(power, power)
    promise = np.divide(gained, left, out=np.zeros_like(left), where=apart)
    rows, columns = np.triu_indices(len(blocks), 1)
    best = np.argsort(-promise[rows, columns])[: _LIMITS.narrow_pairs]
    return [(blocks[rows[k]], blocks[columns[k]]) for k in best]


def triples(table: ScoreTable) -> Sets:
    """The best pairs, each with a third."""
    thirds = [blocks[0] for blocks, _ in singles(table)][: _LIMITS.thirds_from]
    found = []
    for pair, _ in pairs(table)[: _LIMITS.triples_from]:
        for third in thirds:
            if all(third is not b and _compatible(third, b) for b in pair):
                score = table.gain([*pair, third])
                if score is not None:
                    found.append(([*pair, third], score))
    return sorted(found, key=lambda item: -item[1].gain)


def _compatible(a: CandidateBlock, b: CandidateBlock) -> bool:
    """False for two scales of one effect, which are one effect."""
    if a.candidate.effect is not b.candidate.effect:
        return True
    scaled = a.candidate.hidden or a.candidate.detail.tau_s is not None
    return not scaled and not set(a.where) & set(b.where)
