# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""State of the preprocessing pipeline: nested records as views, and its reset."""

import numpy as np
import pytest
from vsa_estimator.preprocessing.pipeline import Pipeline, preprocess
from vsa_estimator.preprocessing.sensor_flags import SensorFlag
from vsa_estimator.preprocessing.validation import ACCEPT, DROP
from vsa_estimator.settings import EstimatorConfig

MS = 1_000_000


def samples(count, seed=1):
    rng = np.random.default_rng(seed)
    k = np.arange(count)
    deflection = 0.01 + 0.002 * np.sin(0.01 * k) + rng.normal(0.0, 1e-5, count)
    return [(10**12 + MS * i, float(30.0 + rng.normal(0.0, 0.017)), float(place)) for i, place in enumerate(deflection)]


def test_samples_write_through_to_every_nested_record():
    pipeline = Pipeline(EstimatorConfig())
    for sample in samples(100):
        assert preprocess(pipeline.state, *sample)[0] == ACCEPT
    state = pipeline.state[0]
    assert state["validation"]["last_stamp_ns"] == state["timestamps"]["last_instant_ns"] == 10**12 + 99 * MS
    assert state["timestamps"]["clock"]["period_ns"] == MS
    assert np.all(state["timestamps"]["clock"]["intervals_ns"] == MS)
    assert state["timestamps"]["evidence"]["start_deflection"] == samples(100)[-1][2]
    assert state["checks"]["encoder_stuck"]["value"] == state["deflection_outliers"]["last"] == samples(100)[-1][2]
    assert state["checks"]["burst"]["interval_ns"] == pipeline.period_ns == MS
    assert state["decimator"]["finished"][0]["samples"] == 10
    assert pipeline.is_decimating


def test_an_outlier_of_each_sensor_raises_its_flag_and_leaves_the_block():
    pipeline, rows = Pipeline(EstimatorConfig()), samples(60)
    rows[44] = (rows[44][0], 90.0, rows[44][2])
    rows[45] = (rows[45][0], rows[45][1], 0.015)
    flags, blocks = [], []
    for row in rows:
        _, flagged, _, finished = preprocess(pipeline.state, *row)
        flags.append(flagged)
        blocks += pipeline.finished(finished)
    assert flags[44] == SensorFlag.FORCE_OUTLIER
    assert flags[45] == SensorFlag.DEFLECTION_OUTLIER
    assert sum(block.samples - block.forces for block in blocks) == 0
    assert [(block.samples, block.forces) for block in blocks if block.samples < 10][-1] == (8, 8)


@pytest.mark.parametrize("counted", [True, False])
def test_samples_that_arrive_together_are_a_burst_unless_the_sample_clock_gives_their_instants(counted):
    pipeline, rows = Pipeline(EstimatorConfig()), samples(9000)
    flags = 0
    if counted:
        pipeline.count_lost(0)
    for k, (stamp_ns, force, deflection) in enumerate(rows):
        arrival_ns = stamp_ns
        for length, every in ((10, 100), (300, 3000)):  # [samples] late at the end of each interval
            if k % every >= every - length:
                arrival_ns = max(arrival_ns, stamp_ns + MS * (every - k % every) - 20_000 * (every - k % every))
        _, flagged, _, _ = preprocess(pipeline.state, arrival_ns, force, deflection)
        flags |= flagged if k > 5000 else 0
    assert bool(flags & SensorFlag.BURST) is not counted
    assert bool(flags & SensorFlag.TIMING_SUSPECT) is not counted


def test_reset_restores_the_initial_state_but_late_stamps_stay_late():
    pipeline, rows = Pipeline(EstimatorConfig()), samples(100)
    for row in rows:
        preprocess(pipeline.state, *row)
    pipeline.set_beyond_peak_speed(True)
    pipeline.reset()
    initial = Pipeline(EstimatorConfig()).state
    for name in initial.dtype.names:
        if name != "validation":
            assert pipeline.state[name].tobytes() == initial[name].tobytes(), name
    assert pipeline.period_ns == 0.0
    assert pipeline.force_noise_ratio == pipeline.deflection_noise_ratio == 1.0
    assert preprocess(pipeline.state, *rows[-1])[0] == DROP
