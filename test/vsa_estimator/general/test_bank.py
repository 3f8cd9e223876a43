# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The bank of laws on simulated transmissions whose law it does not know."""

import numpy as np
import pytest
from vsa_common.accel import ACCELERATED
from vsa_estimator.estimator import Estimator
from vsa_estimator.fault_detection.consistency import Decision
from vsa_estimator.general.bank import Bank
from vsa_estimator.general.impedance import member_impedance
from vsa_estimator.general.models import MODELS
from vsa_estimator.general.records import IMPEDANCE
from vsa_estimator.modes import Event, Mode
from vsa_estimator.settings import EstimatorConfig, Initial
from vsa_estimator.tuning.general import RELAXATION_TIMES
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.internal import ViscoelasticConfig
from vsa_simulator.laws.springs import SpringConfig
from vsa_simulator.rig.config import SensorErrorConfig
from vsa_simulator.rig.motion import Tone, tones
from vsa_simulator.rig.recording import Recording, Simulation, TransmissionVariant

pytestmark = pytest.mark.skipif(not ACCELERATED, reason="the bank is too slow in plain Python")

MIX = tones(0.0095, Tone(0.0032, 0.07), Tone(0.00025, 0.6, 1.1), Tone(0.0001, 1.2, 2.2))
RELAXATION_MEMBER = [model.name for model in MODELS].index("relaxation")
NOISE = (0.017**2, 1e-10 + 1e-10 / 12.0)  # variances of force [N^2] and deflection [m^2]


def simulated(spring="exponential", duration=30.0, **sensor_errors):
    laws = ForceLaws(spring=SpringConfig(spring)) if spring != "exponential" else ForceLaws()
    variant = TransmissionVariant(laws=laws, sensor_errors=SensorErrorConfig(**sensor_errors))
    simulation = Simulation(variant, MIX, duration=duration, rate_hz=100)
    return simulation, simulation.recording(seed=1)


def run(bank, recording, part=slice(None)):
    """ln stiffness and its variance after each sample of a part (n, 2); repetitions end at once."""
    forces, deflections = recording.force[part], recording.deflection[part]
    out = np.zeros((forces.size, 2))
    for i, (force, deflection) in enumerate(zip(forces, deflections, strict=True)):
        bank.step(0.01, (float(deflection), NOISE[1]), (float(force), NOISE[0]))
        while bank.is_repeating:
            bank.repeat_slice()
        out[i] = bank.impedance[0]["ln_stiffness"], bank.impedance[0]["ln_stiffness_variance"]
    return out


def test_the_stiffness_of_unknown_springs_is_accurate_and_the_intervals_hold():
    covered = []
    for spring in ("quadratic", "sinh", "linear"):
        simulation, recording = simulated(spring)
        ln_stiffness, variance = run(Bank(Initial(), 100.0), recording)[2000:].T
        error = ln_stiffness - np.log(simulation.stiffness[2000:])
        assert np.median(np.abs(error)) < 0.005, spring
        covered.append(np.mean(np.abs(error) < 1.96 * np.sqrt(variance)))
    assert np.mean(covered) > 0.9  # errors of one run are correlated over seconds


@pytest.mark.parametrize("spring", ["quadratic", "linear"])
def test_the_elastic_law_covers_the_true_one_at_its_knots(spring):
    simulation, recording = simulated(spring)
    bank = Bank(Initial(), 100.0)
    run(bank, recording)
    knots, ln_stiffness, covariance, force = bank.elastic_law()
    order = np.argsort(simulation.deflection)
    true = np.interp(knots, simulation.deflection[order], np.log(simulation.stiffness[order]))
    inside = (knots > simulation.deflection.min()) & (knots < simulation.deflection.max())
    assert (inside.sum(), inside.size) == (inside.size - 6, len(ln_stiffness))  # one interval beyond the motion
    std = np.sqrt(np.diag(covariance))
    assert min(std[0], std[-1]) > 3.0 * std[inside].max()
    error = (ln_stiffness - true)[inside]
    assert np.abs(error).max() < 0.03
    assert np.mean(np.abs(error) < 2.5 * np.sqrt(np.diag(covariance)[inside])) > 0.8
    assert np.linalg.eigvalsh(covariance).min() > -1e-12
    slow = np.abs(simulation.velocity) < 1e-4  # there the damper bears below 0.4 N
    work = np.cumsum(np.diff(knots) * np.exp(0.5 * (ln_stiffness[:-1] + ln_stiffness[1:])))
    expected = np.interp(simulation.deflection[slow], knots, force + np.append(0.0, work))
    assert np.mean(simulation.force[slow]) == pytest.approx(np.mean(expected), abs=1.0)


def test_a_relaxation_that_the_motion_does_not_separate_stays_uncertain():
    # time constant 3 s, tones of 5 and 0.6 s: a regression on the true motion leaves 6 % for the static stiffness
    motion = tones(0.0105, Tone(0.001, 0.19), Tone(0.00015, 1.81, 1.0))
    laws = ForceLaws(viscoelastic=ViscoelasticConfig(share=0.12, time_constant=3.0))
    simulation = Simulation(TransmissionVariant(laws=laws), motion, duration=45.0, rate_hz=100)
    bank = Bank(Initial(), 100.0)
    run(bank, simulation.recording(seed=3))
    part, one = np.zeros(1, IMPEDANCE), bank._members[RELAXATION_MEMBER : RELAXATION_MEMBER + 1]
    member_impedance(one, bank._geometry, part)
    error, std = part["ln_stiffness"][0] - np.log(simulation.stiffness[-1]), np.sqrt(part["ln_stiffness_variance"][0])
    assert abs(error) < 2.0 * std
    assert 0.03 < std < 0.15


@pytest.mark.parametrize("restored", [False, True])
def test_a_relaxation_continues_after_held_coefficients(restored):
    """They are held for 4 s, or from 20 s on again at 24 s, while the rod moves: the relaxation has gone on."""
    laws = ForceLaws(viscoelastic=ViscoelasticConfig(share=0.2, time_constant=2.0))
    simulation = Simulation(TransmissionVariant(laws=laws), MIX, duration=32.0, rate_hz=100)
    recording, bank = simulation.recording(seed=1), Bank(Initial(), 100.0)
    run(bank, recording, slice(2000))
    assert "relaxation" in bank.description
    if restored:
        checkpoint = bank.copied()
        run(bank, recording, slice(2000, 2400))
        checkpoint.take_memory(bank)
        bank = checkpoint
    else:
        for deflection in recording.deflection[2000:2400]:
            bank.follow(0.01, float(deflection))
    bank.interrupt(0.01, (float(recording.deflection[2400]), NOISE[1]))
    out = run(bank, recording, slice(2401, None))
    assert "relaxation" in bank.description
    error = out[:, 0] - np.log(simulation.stiffness[2401:])
    assert np.mean(np.abs(error) < 2.0 * np.sqrt(out[:, 1])) > 0.95


def test_the_relaxation_of_a_gap_at_rest_decays():
    _, recording = simulated(duration=10.0)
    bank = Bank(Initial(), 100.0)
    run(bank, recording)
    member = bank._members[RELAXATION_MEMBER]
    before, position = member["relaxation"].copy(), float(member["deflection"])
    bank.interrupt(2.0, (position, NOISE[1]))
    expected = before * np.exp(-2.0 / np.array(RELAXATION_TIMES))
    assert bank._members[RELAXATION_MEMBER]["relaxation"] == pytest.approx(expected, abs=1e-6 * np.abs(before).max())


def test_the_exponential_law_has_the_greatest_probability_on_the_papers_transmission():
    _, recording = simulated()
    bank = Bank(Initial(), 100.0)
    run(bank, recording)
    assert bank.exponential_probability > 0.5


def test_a_lagging_force_is_attributed_to_a_delay():
    _, recording = simulated(force_delay=0.005)
    bank = Bank(Initial(), 100.0)
    run(bank, recording)
    assert "delay" in bank.description


def test_after_a_gap_the_law_is_kept():
    simulation, recording = simulated("quadratic")
    bank = Bank(Initial(), 100.0)
    run(bank, recording)
    bank.interrupt(0.01, (float(recording.deflection[-1]), NOISE[1]))
    bank.step(0.01, (float(recording.deflection[-1]), NOISE[1]), (float(recording.force[-1]), NOISE[0]))
    assert bank.impedance[0]["ln_stiffness"] == pytest.approx(np.log(simulation.stiffness[-1]), abs=0.05)


def test_after_a_gap_the_impedance_is_that_at_the_new_position():
    simulation, recording = simulated("quadratic")
    bank = Bank(Initial(), 100.0)
    run(bank, recording)
    other = int(np.argmax(np.abs(recording.deflection - recording.deflection[-1])))
    bank.interrupt(0.01, (float(recording.deflection[other]), NOISE[1]))
    assert bank.impedance[0]["motion"][0] == pytest.approx(recording.deflection[other])
    assert abs(np.log(simulation.stiffness[other] / simulation.stiffness[-1])) > 0.3
    assert bank.impedance[0]["ln_stiffness"] == pytest.approx(np.log(simulation.stiffness[other]), abs=0.05)


@pytest.mark.parametrize(("spring", "mode"), [("exponential", Mode.TRACKING), ("quadratic", Mode.GENERAL)])
def test_the_estimator_changes_to_the_bank_only_where_the_law_is_refuted(spring, mode):
    simulation, recording = simulated(spring, 40.0)
    estimator = Estimator(EstimatorConfig(elastic_law="automatic"))
    rows = estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)
    assert estimator._supervisor.modes.mode is mode
    error = rows["stiffness"][3000:] / simulation.stiffness[3000:] - 1.0
    assert rows["stiffness_valid"][3000:].all()
    assert np.median(np.abs(error)) < 0.005


@pytest.mark.parametrize(("spring", "mode"), [("exponential", Mode.SUSPENDED), ("quadratic", Mode.GENERAL)])
def test_an_inconsistency_while_the_bank_is_published_is_one_of_the_law(spring, mode, monkeypatch):
    _, recording = simulated(spring, 20.0)
    estimator = Estimator(EstimatorConfig(elastic_law="automatic"))
    before, after = slice(1995), slice(1995, 2000)
    estimator.add_many(recording.stamp_ns[before], recording.force[before], recording.deflection[before])
    supervisor = estimator._supervisor
    assert supervisor.modes.mode is Mode.TRACKING
    supervisor.laws.impedance["ln_stiffness_variance"] = 0.1  # as in a part of the stroke that is new to the bank
    assert supervisor.laws.explains_inconsistency is (mode is Mode.GENERAL)
    decision = Decision(Event.INCONSISTENT)
    monkeypatch.setattr(supervisor.consistency, "evaluate", lambda *_: decision)
    estimator.add_many(recording.stamp_ns[after], recording.force[after], recording.deflection[after])
    assert supervisor.modes.mode is mode


def test_k2_of_the_bank_needs_no_travel_of_the_filter():
    simulation, recording = simulated("quadratic", 40.0)
    estimator = Estimator(EstimatorConfig(elastic_law="automatic"))
    estimator.add_many(recording.stamp_ns, recording.force, recording.deflection)
    tracker = estimator._supervisor.tracker
    tracker.set_stroke(tracker.position, tracker.position)  # as after a gap
    state = estimator.state()
    assert estimator._supervisor.modes.general
    assert state.k2_valid
    slope = np.polyfit(simulation.deflection, np.log(simulation.stiffness), 4)
    true = np.polyval(np.polyder(slope), state.deflection)
    assert state.k2 == pytest.approx(true, rel=0.1)
    assert not any(line.startswith("k2:") for line in state.observability)


@pytest.mark.parametrize(("shift", "force_shift"), [(0.0, 0.0), (1.5e-3, 0.0), (0.0, 5.0)])
def test_a_repetition_passes_a_gap_and_a_shift_of_either_sensor(shift, force_shift):
    simulation, recording = simulated("quadratic", duration=20.0)
    bank = Bank(Initial(), 100.0)
    for i, (force, deflection) in enumerate(zip(recording.force, recording.deflection, strict=True)):
        moved = (float(deflection) + (shift if i >= 800 else 0.0), NOISE[1])
        force += force_shift if i >= 800 else 0.0
        if i == 800:  # after that at 8 s
            bank.shift(shift, force_shift)
            bank.interrupt(0.01, moved)
            continue
        bank.step(0.01, moved, (float(force), NOISE[0]))
        while bank.is_repeating:
            bank.repeat_slice()
    assert abs(bank.impedance["ln_stiffness"][0] - np.log(simulation.stiffness[-1])) < 0.01


def test_a_rest_takes_no_place_among_the_steps_that_are_repeated():
    """A rest of 40 s at a reversal; the bank keeps 24 s of steps."""
    simulation, recording = simulated("quadratic", duration=20.0)
    turn = 300 + int(np.argmin(np.abs(simulation.velocity[300:600])))
    noise = np.random.default_rng(2).standard_normal((2, 4000))
    force = np.insert(recording.force, turn, recording.force[turn] + 0.017 * noise[0])
    deflection = np.insert(recording.deflection, turn, recording.deflection[turn] + 1e-5 * noise[1])
    bank, moving = Bank(Initial(), 100.0), Bank(Initial(), 100.0)
    run(bank, Recording(np.arange(force.size), force, deflection))
    run(moving, recording)
    assert bank.repetitions == moving.repetitions == 6
    assert bank.age == pytest.approx(moving.age, abs=1.0)
    assert abs(bank.impedance["ln_stiffness"][0] - np.log(simulation.stiffness[-1])) < 0.01


def test_a_copy_goes_on_as_the_bank_would():
    _, recording = simulated("quadratic", duration=12.0)
    bank, alone = Bank(Initial(), 100.0), Bank(Initial(), 100.0)
    for part in (bank, alone):
        run(part, recording, slice(800))
    copied = bank.copied()
    before = bank.impedance.copy()
    for part in (copied, alone):
        run(part, recording, slice(800, None))
    assert copied.repetitions == alone.repetitions == 5
    assert np.array_equal(copied.impedance, alone.impedance)
    assert np.array_equal(bank.impedance, before)


def test_the_exponential_law_can_be_excluded_until_the_next_start():
    _, recording = simulated(duration=8.0)
    bank = Bank(Initial(), 100.0)
    run(bank, recording, slice(700))
    assert bank.exponential_probability > 0.5
    bank.exclude_exponential()
    run(bank, recording, slice(700, None))
    assert bank.exponential_probability == 0.0
    bank.restart()
    run(bank, recording, slice(700))
    assert bank.exponential_probability > 0.5


def test_a_member_that_has_diverged_has_no_part_in_the_mixture():
    _, recording = simulated(duration=6.0)
    bank = Bank(Initial(), 100.0)
    run(bank, recording, slice(500))
    bank._members["mean"][3] = np.nan
    run(bank, recording, slice(500, None))
    assert bank._probabilities[3] == 0.0
    assert np.isfinite(bank.impedance["ln_stiffness_variance"][0])
