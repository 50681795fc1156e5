"""Tuned numbers of shots and of flaws of their samples, as thresholds.py explains them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Shots:
    """Which part of a record is used, and on which grid of instants it is compared with the model."""

    # share of the first amplitude to which a shot is fitted; below, a rotor may stick [unset]
    kept_amplitude: float = 0.12
    first_part: int = 8  # a fit that finds no minimum begins with one part in so many of an angle's window [A]
    spring_share: float = 0.1  # of a pendulum's chi^2, below which an angle is that of a linear spring [unset]
    beginning_s: float = 0.1  # of a rotor's shot in which one angle is near enough to begin with [unset]
    stray_ratio: float = 3.0  # of two frequencies: a trial step that leads further away is refused [A]
    large_array_bytes: int = 1_000_000  # from which on the memory of an array is given back when it is freed [cost]
    kept_heap_bytes: int = 16_000_000  # of freed small arrays, that are kept for the next ones [cost]
    kept_bases: int = 2  # linearised states of a shot that are cached, some megabytes each [cost]
    kept_coefficients: int = 20  # of a model up to which its states are cached: with the course of a torque none [cost]
    largest_sensitivity: float = 1e60  # of the basis functions; beyond, the trajectory is lost [digits]
    full_rate_s: float = 0.05  # s at the start that keep every sample: transients of the switch live there [unset]
    full_rate_samples: int = 6_000  # per channel; a shorter record keeps every sample [cost]
    least_decimated: int = 1_500  # instants that decimation must leave to be worth its filter [cost]
    pass_band: float = 6.5  # upper edge of the pass band, in fundamentals: six harmonics [unset]
    nyquist: float = 7.5  # Nyquist frequency after decimation, in fundamentals: room for the filter's edge [cost]
    even_nyquist: float = 15.0  # the same where one grid covers a shot, whose filter is short: a rotor's [cost]
    ripple_db: float = 130.0  # dB of the filter: ripple is an error of m_r, whose std may be 1e-6 of it [D, was 90]
    # relative variation of the noise level in the band below which it counts as white [unset]
    white_share: float = 0.02
    level_band_from: float = 0.3  # lower edge of the band where the noise's level is read, in fundamentals [unset]
    level_points: int = 24  # frequencies of that band [unset]
    # Stale samples: how often samples that are equal exceed what digits of nearly equal ones make, in its sigma [noise]
    stale_sigma: float = 6.0
    stale_ratio: float = 4.0  # times these at least: of a coarse encoder twice as many are equal by chance [physics]
    stale_digits: int = 10  # of the last one, within which samples count as nearly equal [unset]
    # Mean distance of steps from multiples of the smallest one, up to which that is a digit: 0, or a quarter [physics]
    stale_whole: float = 0.1
    most_stale_share: float = 0.1  # of all samples; beyond, the record holds its values [unset]
    longest_stale: int = 4  # samples in a row that one value stands for; a rotor at rest has more [unset]
