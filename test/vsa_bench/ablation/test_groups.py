# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Groups of recordings: each module of constants has one, the recordings have the faults they name."""

from argparse import Namespace
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from vsa_bench.ablation import trial
from vsa_bench.ablation.command import evaluate
from vsa_bench.ablation.disturbances import DISTURBANCES, MILLISECOND
from vsa_bench.ablation.groups import GROUPS, groups_of
from vsa_bench.ablation.offline import Identified, Rest, offline_recordings
from vsa_bench.ablation.other_laws import OtherLaw, with_other_laws
from vsa_bench.ablation.recordings import simulated
from vsa_bench.ablation.trial import initialize_worker, run_trial
from vsa_bench.ablation.variation import DOUBLE, HALF, declared, vary
from vsa_bench.estimation.cases import case
from vsa_common.accel import ACCELERATED


@pytest.fixture(scope="module")
def healthy():
    return simulated(case(motion="multisine", rate_hz=500, start="good"), "force", 4.0)


def in_worker(sources, *overrides):
    with ProcessPoolExecutor(1, get_context("fork"), initialize_worker, (sources,)) as pool:
        return list(pool.map(run_trial, overrides))


def halved(name):
    module = f"{trial.PACKAGE}.tuning.{name.partition('.')[0]}"
    return vary(module, declared(trial.PACKAGE)[module][name.partition(".")[2]], HALF)


def test_each_module_of_constants_has_groups_that_exist():
    for module in declared(trial.PACKAGE):
        assert set(groups_of(module)) <= set(GROUPS)
        assert groups_of(module)


@pytest.mark.parametrize("name", DISTURBANCES)
def test_a_disturbance_changes_samples_or_stamps_and_keeps_the_truth(healthy, name):
    result = DISTURBANCES[name][0](healthy, np.random.default_rng(1))
    fields = ("stamps_ns", "force", "deflection")
    assert not all(np.array_equal(getattr(result, field), getattr(healthy, field)) for field in fields)
    assert np.isin(result.stiffness, healthy.stiffness).all()
    assert len(result.stamps_ns) == len(result.force) == len(result.deflection) == len(result.damping)


@pytest.mark.parametrize("name", ["delays", "jitter", "losses"])
def test_delayed_stamps_keep_the_order_of_the_samples(healthy, name):
    result = DISTURBANCES[name][0](healthy, np.random.default_rng(1))
    assert (np.diff(result.stamps_ns) > 0).all()


def test_delays_reach_a_quarter_of_a_second(healthy):
    delayed = DISTURBANCES["delays"][0](healthy, np.random.default_rng(1))
    late_ns = delayed.stamps_ns - healthy.stamps_ns
    assert late_ns.min() >= 0
    assert 200 * MILLISECOND < late_ns.max() < 300 * MILLISECOND


def test_coefficients_and_noise_are_found_offline():
    moving, *_ = (one for one in offline_recordings(12.0) if isinstance(one, Identified))
    resting = [one for one in offline_recordings(12.0) if isinstance(one, Rest)]
    (result,) = in_worker([moving, *resting], {})
    assert result.failure == ""
    assert result.figures[moving.name].stiffness_nrmse < 0.05
    assert {one.white for one in resting} == {True, False}
    for one in resting:
        assert result.figures[one.name].noise_error < 0.1


def test_a_constant_of_offline_changes_what_is_identified():
    one = next(iter(offline_recordings(12.0)))
    base, varied = in_worker([one], {}, halved("offline.REVERSAL_SPEED").overrides)
    assert base.digests != varied.digests


@pytest.mark.skipif(not ACCELERATED, reason="the bank is too slow in plain Python")
def test_a_constant_of_the_bank_of_laws_changes_compiled_code():
    one = next(with_other_laws(4.0))
    assert type(one) is OtherLaw
    base, varied = in_worker([one], {}, halved("general.STRIBECK_SPEEDS").overrides)
    assert base.failure == varied.failure == ""
    assert base.digests != varied.digests


def test_a_constant_without_effect_on_one_group_is_tried_on_the_next(monkeypatch, healthy):
    moving = simulated(case(motion="multisine", start="good"), "force", 1.0)
    disturbed = DISTURBANCES["bad values"][0](healthy, np.random.default_rng(1))
    sources = {"tracking": [moving], "samples": [disturbed], "rare": [disturbed]}
    monkeypatch.setattr("vsa_bench.ablation.command.sources_of", lambda group, quick, seconds: sources[group])
    names = ("preprocessing.OUTLIER_GATE", "filter.SOFT_GATE")
    options = Namespace(group=[], quick=True, seconds=None, processes=1)
    bases, effects = evaluate([halved(name) for name in names], options)
    assert set(bases) == set(sources)
    by_name = {one.variation.name: one for one in effects}
    assert by_name["OUTLIER_GATE"].group == "samples"
    assert by_name["OUTLIER_GATE"].bits_changed
    assert len(effects) == len(names)
    assert DOUBLE not in {one.variation.factor for one in effects}
