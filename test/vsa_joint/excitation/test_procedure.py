# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A run on the simulated rig in its own time: limits, end, faults; and which quantities are known."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from rig_runs import GOAL, Run, changed
from vsa_joint.excitation.inputs import Inputs, measure
from vsa_joint.excitation.procedure import ExcitationRefused, Procedure
from vsa_joint.excitation.quantities import UNITS, KnownQuantities, estimate_of
from vsa_joint.excitation.sample_rate import SampleRate
from vsa_joint.excitation.settings import ExcitationConfig

SECOND = 1_000_000_000
TRUTH = {1: {"k2": 267.2, "damping": 4000.0, "d2": -1.089e8}, 2: {"k2": 165.6, "damping": 4000.0, "d2": -1.17e8}}


@pytest.fixture(scope="module")
def finished():
    run = Run(seed=3)
    run.finish()
    return run


def test_from_wrong_start_values_all_are_known_sooner_than_by_the_motion_of_the_demo(finished):
    """The demo's motion needs 13 s from such start values."""
    outcome = finished.procedure.outcome
    assert outcome.success
    assert finished.procedure.elapsed(finished.now) < 11.0
    assert outcome.message.startswith("all wanted quantities are known after")


def test_known_values_are_those_of_the_rig(finished):
    for one in finished.procedure.known.estimates:
        assert one.known_after is not None
        expected = TRUTH[one.transmission].get(one.quantity)
        if expected is not None:
            assert abs(one.value - expected) < 4.0 * one.std + 0.01 * abs(expected)


def test_motion_and_joint_stay_within_their_limits(finished):
    mean = np.array(finished.deflections).mean(axis=1)
    assert np.abs(mean - mean[0]).max() < GOAL.travel + 2e-4
    assert np.abs(np.diff(mean)).max() / 0.01 < 1.1 * GOAL.speed
    assert np.abs(finished.angles).max() < 0.05


def test_the_first_command_is_the_measured_position():
    run = Run()
    assert run.step() == run.inputs.motors


def test_a_limit_of_the_tension_narrows_the_range():
    run = Run(goal=changed(GOAL, force_max=36.0, duration=8.0))
    run.finish()
    assert np.max(run.forces) < 36.0 * 1.05
    assert np.max(run.forces) > 32.0


def test_a_wanted_interval_that_is_not_reached_is_stated_at_the_end():
    run = Run(goal=changed(GOAL, quantities=("k2",), relative_interval=1e-5, duration=1.0))
    outcome = run.finish()
    assert not outcome.success
    assert outcome.message.startswith("not known after 1.0 s: k2 of transmission_1 (")


def test_silence_of_an_input_ends_the_run_with_its_name():
    for name, change in (
        ("motor_states silent", {"motors_ns": 0}),
        ("joint_states silent", {"angle_ns": 0}),
        ("transmission_1/estimator_state silent", {"states_ns": [0, 0]}),
    ):
        run = Run()
        run.step()
        for field, value in change.items():
            setattr(run.inputs, field, value)
        held = run.procedure.step(run.inputs, run.now)
        assert run.procedure.outcome.message.endswith(name)
        assert held == pytest.approx(run.inputs.motors, abs=0.01)


def test_an_overload_a_turned_joint_and_motors_that_do_not_follow_end_the_run():
    run = Run()
    run.step()
    run.inputs.measurements[1] = dataclasses.replace(run.inputs.measurements[1], force=201.0)
    run.procedure.step(run.inputs, run.now)
    assert "force of transmission_2 201 N, limit 190 N" in run.procedure.outcome.message
    run = Run()
    run.step()
    run.inputs.angle += 0.4
    run.procedure.step(run.inputs, run.now)
    assert "joint turned by 0.4 rad, limit 0.3 rad" in run.procedure.outcome.message
    run = Run()
    while run.procedure.outcome is None:
        run.rig.command = lambda *_: None
        run.step()
    assert "motors do not follow: is the driver armed?" in run.procedure.outcome.message


def test_a_start_beyond_the_limits_is_refused():
    run = Run()
    for config, text in (
        (ExcitationConfig(deflection_min=0.009), "no room at the start: deflection of transmission_2"),
        (ExcitationConfig(motor_max=0.5), r"motors at .* rad, limits -3 to 0.5 rad"),
    ):
        with pytest.raises(ExcitationRefused, match=text):
            Procedure(config, GOAL, run.inputs, run.now)
    with pytest.raises(ExcitationRefused, match=r"force of transmission_1 .* limit 20 N"):
        Procedure(ExcitationConfig(), changed(GOAL, force_max=20.0), run.inputs, run.now)


def impedance(**changes):
    values = {"force": 30.0, "force_valid": True, "deflection": 0.01, "deflection_valid": True, "status": 2}
    return SimpleNamespace(**{**values, **changes})


def test_a_flagged_sensor_is_tolerated_for_three_seconds_and_a_stale_one_for_the_timeout():
    inputs, timeout = Inputs(), SECOND // 5
    good = measure(impedance(), None, SECOND)
    inputs.measurements[1] = good
    for bad, seconds, text in (
        ({"force_valid": False}, 3.0, "force or deflection invalid"),
        ({"status": 4}, 0.2, "estimator STALE"),
        ({"force": float("nan")}, 0.2, "impedance silent"),
    ):
        within, beyond = (SECOND + round((seconds + change) * SECOND) for change in (-0.05, 0.05))
        inputs.measurements[0] = measure(impedance(**bad), good, within)
        inputs.measurements[1] = measure(impedance(), good, within)
        assert inputs.fault(within, timeout) == "motor_states silent"  # no fault of transmission_1
        inputs.measurements[0] = measure(impedance(**bad), good, beyond)
        assert inputs.fault(beyond, timeout) == f"transmission_1: {text}"


def state(**changes):
    values = dict.fromkeys(("k2", "d1", "d2", "inertia", "force_offset", "coulomb_friction"), 1.0)
    values |= {f"{name}_variance": 0.01 for name in tuple(values)} | {f"{name}_valid": True for name in tuple(values)}
    values |= {"ln_stiffness_reference": np.log(2000.0), "ln_stiffness_reference_variance": 1e-4}
    return SimpleNamespace(**{**values, "elastic_law_valid": True, "observability": (), **changes})


def test_estimates_have_value_deviation_and_reason():
    for name in UNITS:
        assert estimate_of(name, 1, state()).valid
    stiffness = estimate_of("stiffness", 1, state())
    assert (stiffness.value, stiffness.std) == pytest.approx((2000.0, 20.0))
    invalid = estimate_of("damping", 2, state(d1_valid=False, observability=("damping: move slower",)))
    assert (invalid.valid, invalid.reason) == (False, "move slower")
    assert estimate_of("k2", 1, state()).relative_interval == pytest.approx(0.196)


def test_a_quantity_is_known_after_half_a_second_of_validity_within_the_interval():
    known = KnownQuantities(("k2",), 0.2)
    both = [state(), state()]
    for elapsed in (0.0, 0.3):
        known.update(both, elapsed)
        assert not known.all_known
    known.update([state(), state(k2_valid=False)], 0.4)
    known.update(both, 0.6)
    assert [one.known_after for one in known.estimates] == [0.0, None]
    known.update(both, 1.1)
    assert [one.known_after for one in known.estimates] == [0.0, 0.6]
    assert known.all_known
    known.update([state(k2_variance=0.02), state()], 1.2)
    assert [one.transmission for one in known.unknown] == [1]


def test_the_sample_rate_is_that_of_the_counter():
    rate = SampleRate()
    found = [rate.update(round(0.02 * k * SECOND), 10 * k) for k in range(60)]
    assert found[0] == found[10] == 0.0
    assert found[-1] == pytest.approx(500.0)
    assert rate.update(2 * SECOND, 3) == 0.0  # restarted
