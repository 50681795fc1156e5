"""Tuned numbers of the screening, of the windows and of the sliding windows."""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import covered_by, false_alarm, tuned

ANGLE_MOTION = covered_by("screening/test_angle_motion.py")
CLIPPING = covered_by("screening/test_clipping.py")
CREST = covered_by("screening/test_crest.py")
TWO_RESONATORS = covered_by("screening/test_two_resonators.py")
PREPARED_RECORD = covered_by("test_prepared_record.py")
REFUSALS = covered_by("test_refusals.py")


@dataclass(frozen=True, kw_only=True)
class ScreeningThresholds:
    """What is asked of a record before it is fitted, and which samples are."""

    # Angle records: angle_cycles.py
    angle_first_samples: int = tuned(
        64,
        "samples",
        "first stretch in which the frequency of an angle is sought; it is doubled until the next two hold",
    )
    angle_enough_periods: float = tuned(6.0, "periods", "in a stretch from which the frequency of an angle is taken")
    angle_certain_power: float = tuned(
        1e3, "1", "power of an angle's line over the median power, from which the line is certain"
    )
    angle_fewest_cycles: float = tuned(1.5, "periods", "in a stretch: a slower line is the shape of the stretch itself")
    angle_padding: int = tuned(4, "1", "zero padding of the transform of an angle, times its length")
    angle_points_per_period: int = tuned(
        40, "samples", "per period, to which an angle is averaged before its passages are sought"
    )
    angle_first_points: int = tuned(8, "samples", "at least, from which the size of the first swing is read")
    angle_swing_over_noise: float = tuned(6.0, "sd", "that a swing must reach to count as one")
    angle_swing_share: float = tuned(
        0.15, "1", "of the last turning point, that the next swing must reach to count as one"
    )
    angle_zero_rounds: int = tuned(3, "rounds", "of the search for the zero of an angle's scale")
    angle_extremum_share: float = tuned(
        0.1, "periods", "on either side of a turning point, through which a parabola is drawn"
    )

    # Angle records that do not decay: angle_motion.py
    passage_level_share: float = tuned(
        0.3, "1", "of the half range: a passage goes from beyond it to beyond it on the other side"
    )
    decay_half_cycles: int = tuned(20, "half cycles", "from which on a swing must be seen to decay", ANGLE_MOTION)
    decay_sigma: float = tuned(5.0, "sd", "by which a growth is certain, or a decay is excluded", false_alarm("6e-7"))
    lossless_quality: float = tuned(
        5e4, "1", "quality factor beyond that of every swing whose angle is read", ANGLE_MOTION
    )
    revival_share: float = tuned(
        0.25, "1", "of the largest swing, by which it must come back to be driven", ANGLE_MOTION
    )
    revival_half_cycles: int = tuned(7, "half cycles", "that a return takes at least: a push is sudden", ANGLE_MOTION)
    push_share: float = tuned(0.5, "1", "of a return within one period, beyond which it is a push", ANGLE_MOTION)
    median_half_cycles: int = tuned(5, "half cycles", "in the running median of the sizes")
    dithered_share: float = tuned(
        0.03,
        "1",
        "scatter over an encoder's step, below which its steps repeat in every period and say nothing",
        ANGLE_MOTION,
    )
    largest_autocorrelation: float = tuned(
        0.95, "1", "of neighbouring residuals, to which their correlation is limited"
    )
    growth_pair_divisor: int = tuned(
        6, "1", "part of the record that lies between the two points of a pair, from which the usual growth is taken"
    )
    encoder_samples: int = tuned(100_000, "samples", "in which the smallest step of an encoder is sought")

    # Beats of two resonators: beat.py
    beat_point_periods: int = tuned(4, "periods", "in a point of the envelope")
    beat_hop_periods: float = tuned(1.5, "periods", "from one point of the envelope to the next")
    beat_stretch_periods: int = tuned(60, "periods", "of a record that are searched for a beat")
    beat_fewest_points: int = tuned(12, "points", "of the envelope, below which no beat is sought")
    beat_lag_divisor: int = tuned(3, "1", "part of the envelope that is the number of lags of ESPRIT")
    beat_smallest_ratio: float = tuned(0.05, "1", "of the second oscillation to the first", TWO_RESONATORS)
    beat_left_by_two_share: float = tuned(
        0.25, "1", "of the envelope's power, that two rotations along two directions may leave", TWO_RESONATORS
    )
    beat_over_noise: float = tuned(
        3.0, "1", "singular value of a second direction over the noise; neighbouring points share samples"
    )
    beat_left_ratio: float = tuned(0.005, "1", "power left by two rotations over that left by one", TWO_RESONATORS)
    beat_left_by_one_share: float = tuned(
        0.05, "1", "of the envelope's power, that one rotation must leave", TWO_RESONATORS
    )
    beat_apart_cycles: float = tuned(0.1, "periods", "of the beat over the stretch: nearer lines are one")

    # Two lines in the spectrum: separate_lines.py
    far_line_periods: float = tuned(60.0, "periods", "of a record that are searched for a second line")
    far_line_fewest_periods: float = tuned(15.0, "periods", "below which no second line is sought")
    far_line_points_per_period: float = tuned(24.0, "samples", "per period, to which the record is averaged")
    far_line_highest: float = tuned(3.5, "1", "frequency over that of the stronger line, up to which lines are sought")
    far_line_lobe_bins: float = tuned(3.5, "bins", "half width of a line of the Blackman window")
    far_line_sweep_share: float = tuned(0.03, "1", "by which the frequency of a wide swing changes")
    far_line_smallest_ratio: float = tuned(0.05, "1", "of the second line to the first", TWO_RESONATORS)
    far_line_half_share: float = tuned(
        0.02, "1", "by which a line may miss half of the other one and still be its fundamental"
    )
    far_line_left_share: float = tuned(
        0.05, "1", "of the power beside the first line, that both lines may leave", TWO_RESONATORS
    )

    # Clipped samples: clipping.py, screening.py
    clipped_samples: int = tuned(16, "samples", "that pile up at an extreme, from which a record is refused", CLIPPING)
    piled_samples: int = tuned(6, "samples", "at an extreme, from which they are called a pile", CLIPPING)
    piled_ratio: float = tuned(5.0, "1", "of the samples at the extreme to those at the next value", CLIPPING)
    clipped_peaks: int = tuned(2, "peaks", "of an angle that are cut off at the same height", CLIPPING)
    flat_run_samples: int = tuned(4, "samples", "in a run at an extreme")
    extremes_chunk_samples: int = tuned(512, "samples", "in cache at once; speed only")
    equal_share: float = tuned(1e-9, "1", "by which two samples may differ and still be the same value")
    full_scale_samples: int = tuned(8, "samples", "at full scale, from which a record is refused", CLIPPING)
    full_scale_share: float = tuned(0.9999, "1", "of the full scale, from which a sample is clipped")
    flat_runs: int = tuned(8, "runs", "at an extreme, from which dm/dt or volts are clipped", CLIPPING)
    fewest_flat_runs: int = tuned(2, "runs", "at an extreme, below which nothing is clipped", CLIPPING)

    # Is there an oscillation at all? screening.py, prepared_record.py
    fewest_periods: float = tuned(5.0, "periods", "that a window must hold", REFUSALS)
    fewest_samples: int = tuned(64, "samples", "that a record must hold", REFUSALS)
    largest_value: float = tuned(1e100, "1", "of a sample, beyond which its square overflows")
    line_significance: float = tuned(
        60.0, "1", "power of the oscillation's line over the median power, below which there is no signal"
    )
    samples_per_period: float = tuned(4.0, "samples", "per period, below which the sampling is too slow", REFUSALS)
    slowest_hz: float = tuned(
        20.0, "Hz", "below which dm/dt is a drift: a fifth of the slowest resonator whose dm/dt can be seen", REFUSALS
    )
    rounding_share: float = tuned(
        1e-9, "1", "of the signal's rms: smallest standard deviation of the noise that is used"
    )
    rounding_samples: int = tuned(1000, "samples", "from which the signal's rms is taken for that purpose")

    # The crest factor of the decay to 30 %: crest.py, windows.py
    crest_periods: float = tuned(6.0, "periods", "whose harmonics give the waveform", CREST)
    crest_points_per_period: float = tuned(32.0, "samples", "per period, to which the waveform is averaged", CREST)
    crest_harmonics: int = tuned(6, "harmonics", "of the waveform at most", CREST)
    crest_points_per_harmonic: float = tuned(
        2.5, "samples", "in the period of the highest harmonic that is fitted", CREST
    )
    crest_curve_points: int = tuned(128, "points", "at which the waveform is drawn")
    n50_s: float = tuned(0.24, "s", "length of the window N50", "the paper's N50 dataset")
    d30_share: float = tuned(
        0.30,
        "1",
        "of the maximum, to which the peaks have decayed at the end of the window D30",
        "the paper's D30 dataset",
    )
    d30_block_periods: tuple[int, ...] = tuned(
        (2, 6, 20),
        "periods",
        "in a block of the envelope: the first length for which noise cannot fake a crossing",
        CREST,
    )
    d30_over_noise: float = tuned(
        10.0, "sd", "of the first block of the envelope, by which noise cannot fake a crossing", CREST
    )
    d30_first_divisor: int = tuned(4, "1", "part of the record in which the strongest channel is found")
    d30_block_samples: int = tuned(8, "samples", "in a block of the envelope at least")

    # The fundamental: fundamental.py, oscillation.py, frequency_search.py, periods.py, spectral_lines.py
    fundamental_first_samples: int = tuned(
        512, "samples", "of the shortest beginning in which the fundamental is sought"
    )
    fundamental_usual_samples: int = tuned(8192, "samples", "of the beginning that settles most records")
    fundamental_many_points: int = tuned(1000, "samples", "from which a spectrum needs no zero padding")
    fundamental_certain_power: float = tuned(
        1e4, "1", "power of the line over the median power, from which it is certain"
    )
    fundamental_enough_periods: float = tuned(20.0, "periods", "from which a windowed spectrum resolves the line")
    fundamental_trial_periods: float = tuned(0.05, "periods", "from one trial to the next, of a record of few periods")
    fundamental_short_points: int = tuned(600, "points", "to which a record of few periods is averaged")
    fundamental_explained_share: float = tuned(
        0.6, "1", "of the power of a record of few periods, that one sinusoid must explain"
    )
    fundamental_quick_rate_hz: float = tuned(7000.0, "Hz", "to which samples are averaged for the first look")
    fundamental_kept_share: float = tuned(0.5, "1", "of the power, that this averaging must leave")
    fundamental_harmonics: int = tuned(8, "harmonics", "that may be seen, also folded at the sampling rate")
    fundamental_weakest_share: float = tuned(
        1e-4, "1", "of the power at 2f, that the fundamental has in channels that see hardly anything else"
    )
    fundamental_folded_share: float = tuned(
        0.05, "1", "of a line's power, that no folded harmonic from the third on reaches"
    )
    fundamental_over_floor: float = tuned(
        100.0, "1", "power of the fundamental over the median power, beside a stronger line at 2f"
    )
    fundamental_weakest_share_dmdt: float = tuned(
        0.05, "1", "of the power at 2f, over three axes: below 97 degrees the fundamental is the stronger line"
    )
    frequency_search_padding: int = tuned(8, "1", "grid points per resolved frequency step")
    few_periods: float = tuned(
        14.0, "periods", "below which the strongest line of a spectrum may be a side lobe or a harmonic"
    )
    counted_points_per_period: float = tuned(
        16.0, "samples", "per period, to which a record is averaged before its swings are counted", PREPARED_RECORD
    )
    counted_level_share: float = tuned(
        0.5, "1", "of the largest deflection, which noise does not reach from the other side", PREPARED_RECORD
    )
    mains_hz: tuple[float, ...] = tuned((50.0, 60.0), "Hz", "frequencies of mains", "IEC 60038")
    widest_swing_rad: float = tuned(3.0, "rad", "of a motion whose frequency range is computed")

    # Fits along a record: sliding_window.py
    sliding_windows_per_decay: float = tuned(8.0, "1", "of the default length in the window D30")
    sliding_fewest_periods: float = tuned(24.0, "periods", "in a window of the default length")
