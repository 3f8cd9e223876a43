# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parity check of a bank of laws: faults of both sensors on a transmission with a quadratic spring."""

import numpy as np
import pytest
from vsa_common.accel import ACCELERATED
from vsa_estimator.fault_detection.held_law import HeldLaw
from vsa_estimator.fault_detection.isolation import SensorShift
from vsa_estimator.fault_detection.parity_check import ParityCheck
from vsa_estimator.fault_detection.residual import DECISION_WINDOW
from vsa_estimator.general.models import MODELS
from vsa_estimator.law_selection import LawSelection
from vsa_estimator.settings import Initial
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.laws.springs import SpringConfig
from vsa_simulator.rig.motion import Tone, tones
from vsa_simulator.rig.recording import Simulation, TransmissionVariant

pytestmark = pytest.mark.skipif(not ACCELERATED, reason="the bank is too slow in plain Python")

RATE = 100
KNOWN, CHECKED = 25 * RATE, 29 * RATE  # samples of the bank, and of both
NOISE = (1.1e-10, 0.017**2)  # variances of deflection [m^2] and force [N^2]
SHIFTS = [(1.0, 0.0), (0.0, 0.5e-3), (0.0, -0.5e-3)]  # of the force [N] and of the encoder [m]


@pytest.fixture(scope="module")
def identified():
    """A bank after 25 s of a quadratic spring, with the recording."""
    motion = tones(0.0095, Tone(0.0032, 0.2), Tone(0.00025, 0.6, 1.1), Tone(0.0001, 1.2, 2.2))
    variant = TransmissionVariant(laws=ForceLaws(spring=SpringConfig("quadratic")))
    simulation = Simulation(variant, motion, CHECKED / RATE, RATE)
    laws, recording = LawSelection(Initial(), float(RATE)), simulation.recording(seed=2)
    for i in range(KNOWN):
        step(laws, recording, i)
        while laws.bank.is_repeating:
            laws.bank.repeat_slice()
    return laws, recording, simulation


def step(laws, recording, i):
    laws.step(int(recording.stamp_ns[i]), (recording.deflection[i], NOISE[0]), (recording.force[i], NOISE[1]))


def checked(law, recording, force=0.0, deflection=0.0):
    """A parity check against the law after the samples that it does not know, with sensors that read more."""
    parity = ParityCheck(float(RATE), 4e-3)
    parity.keep(law)
    for i in range(KNOWN, CHECKED):
        sample = 1e-9 * recording.stamp_ns[i], recording.deflection[i] + deflection, recording.force[i] + force
        parity.add(sample, NOISE[0], False)
    return parity


def windows(parity):
    """Mean residuals [N] and their standard deviations by the law [N]."""
    return parity._windows[:2]


def test_healthy_sensors_have_small_residuals(identified):
    laws, recording, _ = identified
    parity = checked(HeldLaw(laws.copied()), recording)
    mean, std = windows(parity)
    assert np.abs(mean[1:]).max() < 0.05
    assert 0.0 < std.max() < 0.05
    assert parity.is_consistent and not parity.is_uncertain and not parity.has_expired


@pytest.mark.parametrize(("force", "deflection"), SHIFTS)
def test_the_residual_is_that_of_the_shift(identified, force, deflection):
    laws, recording, simulation = identified
    before, after = (windows(checked(HeldLaw(laws.copied()), recording, *one))[0] for one in ((), (force, deflection)))
    recent = slice(CHECKED - RATE // 2 - 10, CHECKED - 10)
    expected = force - deflection * simulation.stiffness[recent].mean()
    assert after[DECISION_WINDOW] - before[DECISION_WINDOW] == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize(("force", "deflection"), SHIFTS)
def test_a_law_that_is_shifted_as_the_sensor_is_consistent(identified, force, deflection):
    laws, recording, _ = identified
    shift = SensorShift(force, deflection, 1e-3 * (force or deflection))
    law = HeldLaw(laws.copied()).shifted(shift)
    try:
        assert checked(law, recording, force, deflection).is_consistent
    finally:  # the copies share the stored steps
        law.shifted(SensorShift(-force, -deflection, 0.0))


def test_an_isolated_force_offset_has_the_size_of_the_shift(identified):
    laws, recording, _ = identified
    parity = checked(HeldLaw(laws.copied()), recording, force=2.0)
    assert parity.exceeded
    assert parity.isolate_fault().force == pytest.approx(2.0, abs=0.05)


def test_another_plausible_law_neither_drifts_nor_relaxes_unless_the_most_probable_one_does(identified):
    laws = identified[0].copied()
    bank = laws.bank
    assert MODELS[bank.plausible()[0]].name.startswith("any")
    bank._members["ln_likelihood"] = 0.0  # nothing is refuted
    names = {MODELS[m].name for m in bank.plausible()}
    assert names == {
        "exponential, any damper and friction", "any spring", "any spring, delay", "any damper",
        "any damper and friction",
    }  # fmt: skip
    assert len(list(HeldLaw(laws).others())) == len(names) - 1


def test_a_law_with_a_false_form_is_exchanged_for_one_that_explains_the_steps(identified):
    laws, recording, _ = identified
    laws = laws.copied()
    exponential = [model.name for model in MODELS].index("exponential, any damper and friction")
    laws.bank._members["ln_likelihood"][1:] = -5.0
    laws.bank._members["ln_likelihood"][exponential] = 0.0
    laws.bank._probabilities[exponential] = 10.0
    laws.bank._members["mean"][exponential, 38:] *= 1.1  # stiffness of the wrong law
    parity = checked(HeldLaw(laws), recording)
    assert parity.exceeded
    assert parity.choose_law()
    assert parity.is_consistent
    parity = checked(HeldLaw(laws), recording, force=5.0)
    assert not parity.choose_law()
    assert parity.exceeded


def test_a_level_with_a_rate_and_relaxation_explain_slow_faults(identified):
    laws = identified[0].copied()
    laws.bank._members["ln_likelihood"] = -100.0  # refuted, so that the most probable one is alone
    slow = []
    for index, model in enumerate(MODELS[1:], 1):
        laws.bank._probabilities[:] = 0.0
        laws.bank._probabilities[index] = 1.0
        slow += [model.name] if HeldLaw(laws).explains_slow_faults else []
    assert slow == ["wandering level", "relaxation"]


def test_a_widened_law_is_less_certain_of_its_force(identified):
    laws, recording, _ = identified
    law = HeldLaw(laws.copied())
    narrow, wide = (windows(checked(one, recording))[1] for one in (law, law.widened(0.05**2)))
    assert (wide > 2.0 * narrow).all()


def test_without_steps_no_residual_is_evaluated(identified):
    laws, recording, _ = identified
    parity = ParityCheck(float(RATE), 4e-3)
    for i in range(KNOWN, CHECKED):
        parity.add((1e-9 * recording.stamp_ns[i], recording.deflection[i], recording.force[i]), NOISE[0], False)
    later = laws.copied()
    later._step_ns = int(recording.stamp_ns[CHECKED - 1])
    parity.keep(HeldLaw(later))
    parity.add((1e-9 * later._step_ns + 0.06, recording.deflection[-1], recording.force[-1]), NOISE[0], False)
    assert parity.no_evidence
    assert not parity.is_uncertain
