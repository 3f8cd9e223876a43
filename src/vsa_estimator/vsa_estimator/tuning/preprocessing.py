# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Tuned constants of `vsa_estimator.preprocessing`."""

from functools import partial

from vsa_common.tuning import constant

_constant = partial(constant, module=__name__)

# Input validation
IMPLAUSIBLE_RATIO = _constant("IMPLAUSIBLE_RATIO", 10.0, "1", 2.0, 100.0,
    "Multiple of a sensor's limit from which on a magnitude is no measurement", "test_samples_without_a_stamp_or_with_an_implausible_magnitude_are_dropped")  # fmt: skip
MAX_LATENESS_NS = _constant("MAX_LATENESS_NS", 1_000_000_000, "ns", 100_000_000, 10_000_000_000,
    "A stamp further back than this is a time reset, not a late sample or message", "test_a_stamp_far_back_is_a_time_reset_and_its_sample_is_accepted_then")  # fmt: skip
MAX_LATE_RUN = _constant("MAX_LATE_RUN", 50, "samples", 5, 500,
    "As many late samples in a row are a time reset", "test_fifty_late_samples_in_a_row_are_a_time_reset")  # fmt: skip

# Approximate time synchronisation of force and encoder
PAIRING_CAPACITY = _constant("PAIRING_CAPACITY", 2000, "messages", 100, 100_000,
    "Bounds each queue of unpaired messages while the other stream is down", "test_queues_are_bounded_when_one_stream_is_down")  # fmt: skip

# Estimate of the sensor's sample clock
PERIOD_WINDOW = _constant("PERIOD_WINDOW", 32, "intervals", 8, 128,
    "The median of as many intervals initializes the period", "ablation")  # fmt: skip
MAX_JITTER = _constant("MAX_JITTER", 0.3, "periods", 0.05, 1.0,
    "Greatest deviation of an interval that counts as regular, and of a sample before its period", "ablation")  # fmt: skip
MIN_JITTER = _constant("MIN_JITTER", 1e-3, "periods", 1e-4, 1e-2,
    "Keeps the regularity gate open where stamps are exact", "test_true_stamps_are_unchanged_even_or_uneven_with_or_without_losses")  # fmt: skip
JITTER_GATE = _constant("JITTER_GATE", 4.0, "mean deviations", 2.0, 8.0,
    "Gate of the deviation of an interval that counts as regular, and of the lag that agrees with lost samples", "ablation")  # fmt: skip
JITTER_WINDOW = _constant("JITTER_WINDOW", 500.0, "intervals", 50.0, 5000.0,
    "Averages the jitter over several delays of a busy host", "ablation")  # fmt: skip
MAX_INTERVAL_NS = _constant("MAX_INTERVAL_NS", 250e6, "ns", 50e6, 2e9,
    "After a longer silence the phase is initialized again", "ablation")  # fmt: skip
MAX_IRREGULAR = _constant("MAX_IRREGULAR", 100, "samples", 20, 1000,
    "Excess of samples that skip or repeat a period, from which on the rate has changed", "ablation")  # fmt: skip
IRREGULAR_RECOVERY = _constant("IRREGULAR_RECOVERY", 0.5, "samples", 0.1, 1.0,
    "Reduction of the excess by a sample that follows after one period", "ablation")  # fmt: skip
MIN_LOOP_WINDOW = _constant("MIN_LOOP_WINDOW", 16.0, "samples", 4.0, 64.0,
    "Acquisition: the phase-locked loop corrects period and phase after few samples", "ablation")  # fmt: skip
MAX_LOOP_WINDOW = _constant("MAX_LOOP_WINDOW", 256.0, "samples", 64.0, 1024.0,
    "In lock: a minimum delay of many samples is nearly free of delay; time constant of the share off the grid", "ablation")  # fmt: skip
COUNTED_LOOP_WINDOW = _constant("COUNTED_LOOP_WINDOW", 4096.0, "samples", 256.0, 32768.0,
    "The same where the driver counts lost samples: all samples of a shorter window may be delayed", "docs/decisions/0006-timestamps.md")  # fmt: skip
OVERLOAD_DELAY = _constant("OVERLOAD_DELAY", 0.5, "periods", 0.3, 5.0,
    "Delay of all samples of half a window that is an overload of the host where lost samples are counted: a loop in lock drifts by less",
    "docs/decisions/0006-timestamps.md")  # fmt: skip
MAX_OVERLOAD_NS = _constant("MAX_OVERLOAD_NS", 20e9, "ns", 2e9, 200e9,
    "A delay of all samples for longer is a change of phase or rate: the clock is initialized again", "docs/decisions/0006-timestamps.md")  # fmt: skip
LOCKED_DRIFT = _constant("LOCKED_DRIFT", 0.2, "periods", 0.05, 0.5,
    "Drift over half a window below which the loop is in lock and its window doubles", "ablation")  # fmt: skip
LOCKED_GAIN = _constant("LOCKED_GAIN", 0.5, "1", 0.1, 1.0,
    "Share of the drift by which a loop in lock corrects the period", "ablation")  # fmt: skip
MIN_PERIOD_RATIO = _constant("MIN_PERIOD_RATIO", 0.5, "1", 0.1, 1.0,
    "Bounds the correction of the period in one window", "ablation")  # fmt: skip
MISCOUNT_ADVANCE = _constant("MISCOUNT_ADVANCE", 0.1, "periods", 0.02, 0.5,
    "A sample earlier than this results from a miscounted loss, not from a wrong period", "ablation")  # fmt: skip

# Lost samples
MAX_GAPS = _constant("MAX_GAPS", 1000, "gaps", 100, 100_000,
    "Bounds the gaps in the sequence numbers whose samples have not come", "test_gaps_are_bounded_without_samples")  # fmt: skip
CATCH_UP_RATIO = _constant("CATCH_UP_RATIO", 0.5, "periods", 0.1, 1.0,
    "A shorter interval shows that delayed samples catch up", "ablation")  # fmt: skip
CATCH_UP_HOLD = _constant("CATCH_UP_HOLD", 1000, "samples", 100, 10_000,
    "After a catch-up a long interval is a delay, not a loss, for this hold-off", "test_sample_clock_is_estimated_from_a_sender_that_catches_up_slowly")  # fmt: skip
INTEGER_TOLERANCE = _constant("INTEGER_TOLERANCE", 0.15, "periods", 0.05, 0.4,
    "A lag this close to whole periods agrees with lost samples; greatest jitter at which a return from a delay is a re-lock", "ablation")  # fmt: skip
LOSS_RUN = _constant("LOSS_RUN", 2.0, "samples", 1.0, 10.0,
    "As many samples with the same whole lag prove a loss where the stamps are on the grid; fewer are a delay", "ablation")  # fmt: skip
OFF_GRID_LOSS_RUN = _constant("OFF_GRID_LOSS_RUN", 14.0, "samples", 4.0, 60.0,
    "Additional run where all stamps are off the grid of whole periods", "ablation")  # fmt: skip
MAX_DELAYED_NS = _constant("MAX_DELAYED_NS", 200e6, "ns", 50e6, 1e9,
    "Samples delayed for longer have been lost: a busy host catches up sooner", "ablation")  # fmt: skip
MAX_DELAY_NS = _constant("MAX_DELAY_NS", 40e6, "ns", 10e6, 200e6,
    "A longer delay without catch-up is a loss", "ablation")  # fmt: skip
MIN_DELAY_GROWTH = _constant("MIN_DELAY_GROWTH", 1.25, "1 per sample", 1.05, 2.5,
    "The least delay of a run rises while further samples are lost", "ablation")  # fmt: skip
LOSS_RATE_WINDOW = _constant("LOSS_RATE_WINDOW", 16.0, "delays", 4.0, 64.0,
    "Time constant of the share of delays that were losses", "ablation")  # fmt: skip
HOLD_OFF_EXPONENT = _constant("HOLD_OFF_EXPONENT", 6, "1", 2, 12,
    "The hold-off before a loss shrinks with this power of the share of mere delays", "ablation")  # fmt: skip

# Sequential test between stamp and sample clock
MAX_RUN_NS = _constant("MAX_RUN_NS", 100e6, "ns", 20e6, 500e6,
    "Longer runs of delayed samples are no evidence: the motion is not uniform", "ablation")  # fmt: skip
RESIDUAL_RUNS = _constant("RESIDUAL_RUNS", 20.0, "runs", 5.0, 100.0,
    "Memory of the mean square residual of a sample", "ablation")  # fmt: skip
MIN_RESIDUAL = _constant("MIN_RESIDUAL", 1e-7, "m", 1e-9, 1e-5,
    "Bounds the root mean square residual where the encoder has no noise", "keeps the likelihood ratio finite")  # fmt: skip
LLR_CAP = _constant("LLR_CAP", 2.0, "nat", 0.5, 8.0,
    "Bounds the log likelihood ratio of one run, whose residuals are correlated", "ablation")  # fmt: skip
LLR_RUNS = _constant("LLR_RUNS", 200.0, "runs", 50.0, 1000.0,
    "Exponential fading of the evidence: the load of the host varies", "ablation")  # fmt: skip
DECISION_LLR = _constant("DECISION_LLR", 8.0, "nat", 4.0, 20.0,
    "Log likelihood ratio that decides for clock or stamps: at least four runs", "ablation")  # fmt: skip
MIN_RELOCKS = _constant("MIN_RELOCKS", 2, "1", 1, 10,
    "Re-locks that select the clock while the motion gives no evidence", "ablation")  # fmt: skip

# Stuck-at and run-length tests
STUCK_FORCE_TIME = _constant("STUCK_FORCE_TIME", 0.3, "s", 0.1, 1.0,
    "A force constant for this long during motion is stuck", "ablation")  # fmt: skip
STUCK_ENCODER_TIME = _constant("STUCK_ENCODER_TIME", 0.5, "s", 0.1, 2.0,
    "An encoder constant for this long during a change of force is stuck", "ablation")  # fmt: skip
CONSTANT_ENCODER_TIME = _constant("CONSTANT_ENCODER_TIME", 0.15, "s", 0.05, 0.5,
    "An encoder constant for this long is stationary or stuck", "ablation")  # fmt: skip
STUCK_FORCE_NOISE = _constant("STUCK_FORCE_NOISE", 40.0, "standard deviations", 10.0, 160.0,
    "Change of force beyond sensor noise that proves a constant encoder stuck", "test_a_constant_encoder_during_a_change_of_force_is_stuck_and_a_fault")  # fmt: skip
STUCK_FORCE_FRICTION = _constant("STUCK_FORCE_FRICTION", 2.0, "1", 1.0, 4.0,
    "The same beyond friction", "a reversal at rest changes the force by twice the Coulomb friction")  # fmt: skip
FRICTION_BOUND = _constant("FRICTION_BOUND", 2.0, "standard deviations", 1.0, 4.0,
    "Upper bound of the configured Coulomb friction", "95 % quantile of a Gaussian")  # fmt: skip
STUCK_DEFLECTION_NOISE = _constant("STUCK_DEFLECTION_NOISE", 20.0, "standard deviations", 5.0, 80.0,
    "Change of deflection beyond encoder noise that proves a constant force stuck", "ablation")  # fmt: skip
STUCK_DEFLECTION_STEPS = _constant("STUCK_DEFLECTION_STEPS", 5.0, "encoder steps", 2.0, 20.0,
    "The same beyond quantisation", "ablation")  # fmt: skip
FROZEN_TIME = _constant("FROZEN_TIME", 0.03, "s", 0.01, 0.1,
    "Least duration of a run of equal counts that is a stuck encoder", "test_an_encoder_whose_dither_ceases_is_frozen")  # fmt: skip
RUN_LENGTH_LOG_ODDS = _constant("RUN_LENGTH_LOG_ODDS", 25.0, "1", 10.0, 60.0,
    "Negative log-probability of a run of equal counts that is a stuck encoder", "ablation")  # fmt: skip
REVERSAL_SHARE = _constant("REVERSAL_SHARE", 0.1, "1", 0.02, 0.5,
    "Share of reversals from which on the last digit of the encoder dithers", "test_an_encoder_whose_dither_ceases_is_frozen")  # fmt: skip
RUN_LENGTH_WINDOW = _constant("RUN_LENGTH_WINDOW", 500.0, "samples", 100.0, 5000.0,
    "Time constant of the shares of repetitions and reversals", "ablation")  # fmt: skip
MAX_REPEAT_SHARE = _constant("MAX_REPEAT_SHARE", 0.999, "1", 0.9, 1.0,
    "Bounds the share of repetitions: a long stationary run must not disable the test", "test_an_encoder_whose_dither_ceases_is_frozen")  # fmt: skip

# Variance-ratio test
VARIANCE_WINDOW = _constant("VARIANCE_WINDOW", 20.0, "samples", 5.0, 100.0,
    "Time constant of variance, slope and exceedance share", "ablation")  # fmt: skip
VARIANCE_GATE = _constant("VARIANCE_GATE", 25.0, "1", 9.0, 64.0,
    "Ratio to the configured variance at which a sample counts as an exceedance", "docs/decisions/0030-noise-test.md")  # fmt: skip
EXCEEDANCE_SHARE = _constant("EXCEEDANCE_SHARE", 0.3, "1", 0.1, 0.8,
    "Share of exceedances from which on the sensor is noisy: single outliers are not noise", "docs/decisions/0030-noise-test.md")  # fmt: skip
VARIANCE_RATIO_CAP = _constant("VARIANCE_RATIO_CAP", 1e6, "1", 1e3, 1e9,
    "Bounds the contribution of one sample to the variance ratio", "derivation: decays to VARIANCE_GATE within 12 windows")  # fmt: skip
SEVERE_NOISE_RATIO = _constant("SEVERE_NOISE_RATIO", 30.0, "1", 10.0, 100.0,
    "Ratio of standard deviations from which on the encoder is unusable", "ablation")  # fmt: skip
VIBRATION_AMPLITUDE = _constant("VIBRATION_AMPLITUDE", 2.4, "steepest slopes", 1.0, 8.0,
    "Standard deviation of the residual vibration after a motion of high slew rate: the gate is five of it", "docs/decisions/0030-noise-test.md")  # fmt: skip
UNDAMPED_SLEW = _constant("UNDAMPED_SLEW", 2.0, "high slew rates", 1.0, 8.0,
    "Least slope that counts beyond v*, where the vibration does not decay with the slope: 0.8 N; the measured one has an amplitude of 1.3 N",
    "docs/decisions/0015-vibration.md, test_vibration_beyond_the_peak_speed_is_tolerated_and_below_it_is_noise")  # fmt: skip
VIBRATION_END = _constant("VIBRATION_END", 0.25, "1", 0.05, 1.0,
    "Share of the high slew rate below which the residual vibration has decayed", "test_residual_vibration_after_a_motion_of_high_slew_rate_is_tolerated_until_it_has_decayed")  # fmt: skip
SLEW_MEMORY = _constant("SLEW_MEMORY", 0.8, "s", 0.2, 4.0,
    "Memory of the steepest slope: the residual vibration decays in time, at any sample rate", "ablation")  # fmt: skip
HIGH_SLEW_FORCE = _constant("HIGH_SLEW_FORCE", 10.0, "standard deviations per sample", 2.0, 40.0,
    "Slope of the force that leaves residual vibration", "ablation")  # fmt: skip
SLEW_INTERVAL_NS = _constant("SLEW_INTERVAL_NS", 2e6, "ns", 0.5e6, 10e6,
    "High slew rates are per sample, but per this interval where samples are slower", "ablation")  # fmt: skip

# Timestamp-burst check
BURST_RATIO = _constant("BURST_RATIO", 0.3, "mean intervals", 0.1, 0.8,
    "A shorter interval belongs to a burst of samples queued in transmission", "ablation")  # fmt: skip
BURST_WINDOW = _constant("BURST_WINDOW", 50.0, "samples", 10.0, 500.0,
    "Time constant of the mean interval", "ablation")  # fmt: skip
BURST_SLOWDOWN = _constant("BURST_SLOWDOWN", 10.0, "1", 2.0, 50.0,
    "Factor of that time constant within a burst: its intervals are not typical", "ablation")  # fmt: skip
BURST_INTERVAL_CAP = _constant("BURST_INTERVAL_CAP", 2.0, "mean intervals", 1.0, 5.0,
    "Bounds the contribution of one gap to the mean interval", "ablation")  # fmt: skip
BURST_LIMIT_NS = _constant("BURST_LIMIT_NS", 45e6, "ns", 10e6, 200e6,
    "A burst that covers more sensor time is a fault; a busy sender catches up less", "ablation")  # fmt: skip
MIN_BURST = _constant("MIN_BURST", 12, "samples", 3, 50,
    "Fewer samples are no burst at a low sample rate", "ablation")  # fmt: skip
SUSPECT_TIME_NS = _constant("SUSPECT_TIME_NS", 20e6, "ns", 5e6, 100e6,
    "A burst that covers more sensor time makes the timing suspect: the clock may have stood still", "ablation")  # fmt: skip
MIN_SUSPECT_RUN = _constant("MIN_SUSPECT_RUN", 3.0, "samples", 2.0, 10.0,
    "Fewer samples are not suspect at a low sample rate", "test_a_short_burst_makes_the_timing_suspect_once_and_a_long_one_is_a_fault")  # fmt: skip
ENCODER_FAULT_HOLD_NS = _constant("ENCODER_FAULT_HOLD_NS", 50e6, "ns", 10e6, 200e6,
    "The encoder fault outlasts a burst by this hold time", "ablation")  # fmt: skip

# Outlier filter
OUTLIER_GATE = _constant("OUTLIER_GATE", 10.0, "standard deviations", 5.0, 20.0,
    "Gate of the second difference of white noise", "ablation")  # fmt: skip
VIBRATION_GATE = _constant("VIBRATION_GATE", 3.0, "1", 2.0, 6.0,
    "gate of the second difference of a vibration over its mean magnitude: 1.6 for a steady one, twice that while it grows",
    "docs/decisions/0019-outliers-and-pairs.md")  # fmt: skip
OUTLIER_WINDOW = _constant("OUTLIER_WINDOW", 10.0, "samples", 3.0, 50.0,
    "memory of that mean: three periods of the rod at 500 Hz", "docs/decisions/0019-outliers-and-pairs.md")  # fmt: skip
MAX_OUTLIER_RUN = _constant("MAX_OUTLIER_RUN", 2, "samples", 1, 10,
    "After as many outliers in a row the signal itself has stepped", "ablation")  # fmt: skip

# Decimator
BLOCK_SPAN = _constant("BLOCK_SPAN", 0.95, "filter periods", 0.5, 1.0,
    "Samples that span it complete a block: jitter must not postpone the step by a sample", "ablation")  # fmt: skip
BLOCK_GAP = _constant("BLOCK_GAP", 2.0, "block spans", 1.0, 5.0,
    "A longer interval ends a block early: no mean across a gap", "ablation")  # fmt: skip
PERIOD_GAIN = _constant("PERIOD_GAIN", 0.02, "1", 0.005, 0.1,
    "Gain of the running mean of the sample period", "ablation")  # fmt: skip
REGULAR_RATIO = _constant("REGULAR_RATIO", 3.0, "sample periods", 1.5, 10.0,
    "A longer interval is a gap and does not enter the mean", "ablation")  # fmt: skip
PERIOD_GROWTH = _constant("PERIOD_GROWTH", 1.02, "1 per gap", 1.0, 1.2,
    "Growth of the period with each gap: the sample rate may have fallen", "ablation")  # fmt: skip
MAX_GAP_NS = _constant("MAX_GAP_NS", 1e9, "ns", 0.1e9, 10e9,
    "A longer interval is a silence and leaves the period unchanged", "contract: silence of a reset, docs/reference/faults.md")  # fmt: skip
