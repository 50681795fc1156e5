"""Tuned numbers of the measurement of noise."""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import covered_by, false_alarm, tuned

ANGLE = covered_by("noise/test_angle.py")
SERIES = covered_by("noise/test_series.py")
TONES_AND_DRIFT = covered_by("noise/test_tones_and_drift.py")


@dataclass(frozen=True, kw_only=True)
class NoiseThresholds:
    """How the noise outside the harmonics of the signal is measured."""

    # Spectrum outside the harmonics: model.py, welch.py
    line_significance: float = tuned(
        60.0, "1", "power of the oscillation's line over the median power, below which no signal is masked"
    )
    quiet_share: float = tuned(0.25, "1", "of the bins, by their level, that folded harmonics leave free")
    harmonic_over_noise: float = tuned(
        3.7, "1", "power density over the level of the noise, from which a harmonic is seen"
    )
    quiet_harmonics: int = tuned(3, "harmonics", "in a row that are not seen, after which no more are masked")
    fewest_bins: int = tuned(16, "bins", "beside the harmonics, that tell the level of the noise")
    most_harmonics: int = tuned(24, "harmonics", "that are masked")
    most_bridge_bins: int = tuned(40, "bins", "on either side of a gap, from which its level is read at most")
    fewest_bridge_bins: int = tuned(12, "bins", "the same, at least")
    segment_periods: float = tuned(28.0, "periods", "in a segment of the averaged spectrum")
    segment_samples: int = tuned(
        1024, "samples", "in a segment at least, where few samples a period fold all harmonics into a narrow band"
    )
    silent_segment_samples: int = tuned(4096, "samples", "in a segment at least, of a record without a signal")
    silent_segment_divisor: int = tuned(8, "1", "part of a record without a signal that a segment is")
    line_broadening: float = tuned(
        1.25, "1", "width of a line over the window's lobe: decay and sweep inside a segment broaden it"
    )
    flat_from_share: float = tuned(0.5, "1", "of the band, from which on the level of flat noise is measured")
    flat_to_share: float = tuned(0.8, "1", "of the band, up to which: beyond, a converter's filter may roll off")
    sweep_margin_share: float = tuned(0.01, "1", "of the frequency, by which the range of the fundamental is widened")
    sweep_low: float = tuned(
        0.85, "1", "frequency over that of the strongest line, from which on the fundamental is followed"
    )
    sweep_high: float = tuned(1.25, "1", "the same, up to which it is followed")
    sweep_over_floor: float = tuned(
        30.0, "1", "power of the fundamental of a segment over the median power, from which it is followed"
    )
    offset_bins: int = tuned(4, "bins", "from 0 Hz on, that lack what the removal of the offset took")
    line_half_bins: float = tuned(6.5, "bins", "half width of a tone's line")
    ringing_chance: float = tuned(
        1e-6, "1", "probability that noise alone is taken for a swing", "false-alarm rate, by definition"
    )
    most_kept_results: int = tuned(256, "results", "that a noise model keeps for the shots of a series; memory only")
    welch_kaiser_beta: float = tuned(18.0, "1", "of the window: leakage below 1e-12 of a line's power")
    welch_segments: int = tuned(48, "segments", "at most; more of them hardly improve the level")
    welch_hop_divisor: int = tuned(4, "1", "part of a segment from the beginning of one to that of the next, at least")
    welch_shortest_samples: int = tuned(16, "samples", "in a segment")

    # Noise of an angle: angle.py
    difference_order: int = tuned(8, "1", "of the differences, in which a smooth motion vanishes", ANGLE)
    difference_samples_per_period: float = tuned(
        24.0, "samples", "per period at least: of a sine of 1 rad the differences then leave 1e-7 rad", ANGLE
    )
    difference_means_per_period: float = tuned(
        60.0, "means", "the same for means: kinks, where dry friction changes its sign, are in few of them", ANGLE
    )
    wave_periods: float = tuned(3.0, "periods", "in a window at fewer samples than that")
    wave_harmonics: int = tuned(4, "harmonics", "that are fitted in such a window at most")
    wave_degrees: int = tuned(3, "1", "number of polynomials in time by which their sizes change")
    wave_highest_share: float = tuned(0.45, "1", "of the sampling rate, up to which a harmonic is fitted")
    wave_free_samples: int = tuned(6, "samples", "beyond the columns of such a window")
    wave_detuned: tuple[float, ...] = tuned(
        tuple(0.01 * k for k in range(85, 111)),
        "1",
        "frequencies over that of the line, that are tried: a large swing is slower than a small one",
    )
    wave_means_per_period: float = tuned(12.0, "means", "in such windows of an angle that was smoothed", ANGLE)
    smooth_means_per_period: float = tuned(
        36.0, "means", "per period, down to which an angle that was smoothed is told from one with kinks", ANGLE
    )
    smoothed_ratio: float = tuned(
        10.0, "1", "of the level of means over that of the samples, from which these were smoothed", ANGLE
    )
    smooth_motion_share: float = tuned(
        1e-5,
        "1",
        "of the rms angle and the root of the samples in a mean, below which differences may be the motion's own",
        ANGLE,
    )
    quietest_share: float = tuned(1e-8, "1", "of the rms angle: the steps of a converter of 25 bits", ANGLE)
    fewest_differences: int = tuned(32, "differences", "from which the noise is told")
    cells_per_period: int = tuned(4, "cells", "per period: what breaks the motion's smoothness is in few of them")
    fewest_cells: int = tuned(4, "cells", "in a record")
    broken_power: float = tuned(25.0, "1", "over the usual one: a kink or a jump, no noise", ANGLE)
    motion_rise: float = tuned(
        1.5, "1", "from one scale to the next, twice as long: beyond that it is motion, no noise", ANGLE
    )
    step_samples: int = tuned(100_000, "samples", "in which the size of an encoder's step is sought")
    few_steps: float = tuned(50.0, "steps", "of an encoder, up to which a move must be a whole number of them")
    off_step_share: float = tuned(0.05, "1", "of a step, by which a move may miss a whole number of them")
    on_step_share: float = tuned(0.9, "1", "of the moves, that must be a whole number of steps")
    no_move_share: float = tuned(1e-9, "1", "of the largest angle, below which two samples are equal")

    # Colour of the noise at the signal's harmonics: coloured.py
    law_below: float = tuned(3.0, "1", "the law is drawn from f over this number ...")
    law_above: float = tuned(12.0, "1", "... to f times this one")
    band_ratio: float = tuned(1.2, "1", "of the limits of a band")
    band_values: float = tuned(6.0, "independent values", "in a band at least")
    law_power: int = tuned(3, "1", "highest power of the logarithm of the frequency in the law")
    law_power_sigma: float = tuned(2.0, "sd", "below which a power above 0 is left out of the law", false_alarm("5e-2"))
    law_steps_per_octave: float = tuned(
        8.0, "1", "to which the frequency is rounded, so that the shots of a series share a law"
    )
    colour_sigma: float = tuned(3.5, "sd", "from which noise is coloured", false_alarm("5e-4 per statistic"))
    beside_ratio: float = tuned(1.5, "1", "bands within this factor of a frequency give its level where no law holds")

    # Noise of a series: series.py
    enough_shots: int = tuned(12, "shots", "from which the noise of a series is taken", SERIES)
    tone_rate_hz: float = tuned(
        8000.0, "Hz", "to which blank shots are averaged: tones above half of it are far from any harmonic that matters"
    )
    series_shortest_samples: int = tuned(1024, "samples", "in a shot that is learnt from")
    ringing_slower_share: float = tuned(0.01, "1", "by which a rotor in a blank shot may swing slower than in a shot")
    ringing_faster_share: float = tuned(
        0.08, "1", "the same, faster: a rotor that has nearly come to rest does", SERIES
    )
    level_stretch_samples: int = tuned(4096, "samples", "in a stretch from which the level of a shot is read")
    level_stretches: int = tuned(4, "stretches", "from which the level of a shot is read")
    level_differences: int = tuned(
        3, "1", "order of the differences: a resonance far below the sampling rate vanishes in them"
    )
    unlike_sigma: float = tuned(
        6.0, "sd", "by which the level of a shot differs from that of its series", false_alarm("2e-9")
    )
    unlike_log: float = tuned(
        0.1, "1", "difference of the logarithm of the level, below which it does not matter", SERIES
    )

    # Steady tones and drift: tones_and_drift.py
    tone_kaiser_beta: float = tuned(8.0, "1", "of the window")
    tone_lobe_bins: float = tuned(2.8, "bins", "half width of the window's main lobe")
    tone_padding: int = tuned(4, "1", "grid points per resolved frequency step")
    tone_neighbourhood_bins: float = tuned(40.0, "bins", "on either side, from which the level beside a line is read")
    tone_fewest_bins: int = tuned(8, "bins", "in that neighbourhood")
    tone_power: float = tuned(
        25.0, "1", "over the level beside, from which a line is a tone", false_alarm("one in 1e7 records")
    )
    tone_search_power: float = tuned(
        18.0, "1", "over the median, from which tones are sought; a tone exceeds it wherever it falls between the bins"
    )
    most_tones: int = tuned(16, "tones", "that are fitted too")
    many_peaks: int = tuned(24, "bins", "above that power, from which tones are sought without a closer look")
    tone_stretches: int = tuned(8, "stretches", "in which the size of a tone is compared")
    tone_change_sigma: float = tuned(
        4.0, "sd", "of a change of size, decay or chirp, which a steady tone does not reach", false_alarm("6e-5")
    )
    tone_change_share: float = tuned(0.01, "1", "by which a steady tone may change over the window", TONES_AND_DRIFT)
    mains_change_share: float = tuned(0.15, "1", "the same for mains, which is less steady", TONES_AND_DRIFT)
    mains_fall: float = tuned(
        0.04,
        "1",
        "of the logarithm of its size over the window that a mains voltage may do; changes of a load are steps",
        TONES_AND_DRIFT,
    )
    decay_departure_share: float = tuned(0.1, "1", "of the fall, by which sizes may depart from an exponential decay")
    decay_departure_sigma: float = tuned(3.0, "sd", "the same, by chance")
    tone_chirp_rad: float = tuned(
        0.4, "rad", "per window squared, by which the phase of a steady tone may bend; a quarter of it at either end"
    )
    mains_chirp_rad: float = tuned(2.0, "rad", "the same for mains")
    mains_share: float = tuned(0.005, "1", "by which the frequency of mains may be off")
    tone_missed_bins: float = tuned(0.1, "bins", "by which noise and drift may shift a slow line")
    drift_degree: int = tuned(8, "1", "highest degree of the polynomial of a drift")
    drift_points: int = tuned(256, "points", "to which the residual is averaged before drift is sought")
    drift_points_per_degree: int = tuned(
        4, "points", "for each degree of the polynomial, below which no drift is sought"
    )
    drift_sigma: float = tuned(6.0, "sd", "from which a drift is certain", false_alarm("2e-9"))
