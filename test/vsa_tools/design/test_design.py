# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Spring and cam of section II-B against the paper's numbers and an independent force from the cut surface."""

import csv
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from vsa_common.config.configuration import ConfigurationError
from vsa_tools.design.cam import Follower, cam_for, least_preload, rolled_force
from vsa_tools.design.command import Design, check_cuttable, describe, main
from vsa_tools.design.spring import ExponentialSpring, Specification, spring_from

PAPER = spring_from(Specification(alpha=1.3288))


def force_by_energy(cut_x, cut_y, radius, rate, preload, deflections):
    """Rod force as the slope of the stored energy when a roller of `radius` is set down on the surface."""
    surface = CubicSpline(cut_x, cut_y)

    def centre(x):
        low, high = max(x - 0.999 * radius, cut_x[0]), min(x + 0.999 * radius, cut_x[-1])
        tops = np.linspace(low, high, 400)
        best = tops[np.argmax(surface(tops) + np.sqrt(radius**2 - (tops - x) ** 2))]
        found = minimize_scalar(
            lambda at: -(surface(at) + math.sqrt(max(radius**2 - (at - x) ** 2, 0.0))),
            bounds=(max(best - 2e-5, low), min(best + 2e-5, high)),
            method="bounded",
            options={"xatol": 1e-11},
        )
        return -found.fun

    rest = centre(0.0)

    def energy(x):
        return 0.5 * rate * (preload + centre(x) - rest) ** 2

    step = 2e-5
    return np.array([(energy(x + step) - energy(x - step)) / (2.0 * step) for x in deflections])


def test_alpha_of_the_paper_gives_equation_4_to_its_printed_digits():
    assert f"{PAPER.k1:.4f} {1e-3 * PAPER.k2:.4f} {PAPER.force_offset:.4f}" == "0.9772 0.2658 1.2372"


def test_without_alpha_all_three_conditions_hold():
    spring = spring_from(Specification())
    assert spring.force(0.005) == pytest.approx(5.0, rel=1e-9)
    assert spring.force(0.020) == pytest.approx(200.0, rel=1e-9)
    assert spring.stiffness(0.005) * 0.001 / 5.0 == pytest.approx(0.2, rel=1e-9)


def test_derived_alpha_is_within_1_6_percent_of_equation_4_in_force():
    x = np.linspace(0.0, 0.020, 50)
    assert np.max(np.abs(spring_from(Specification()).force(x) / PAPER.force(x) - 1.0)) < 0.016


def test_stiffness_is_the_derivative_of_force_and_force_that_of_work():
    step = 1e-20
    for x in (0.0, 0.004, 0.019):
        assert PAPER.force(complex(x, step)).imag / step == pytest.approx(PAPER.stiffness(x), rel=1e-12)
        assert PAPER.work(complex(x, step)).imag / step == pytest.approx(PAPER.force(x), rel=1e-12)


@pytest.mark.parametrize("springs", [1, 2])
def test_a_roller_of_3_mm_on_the_cut_surface_gives_the_law_within_half_a_percent(springs):
    follower = Follower(springs=springs, roller_radius=0.003)
    cam = cam_for(PAPER, follower, 0.020)
    x = np.linspace(0.0002, 0.0198, 40)
    force = force_by_energy(cam.cut_x, cam.cut_y, 0.003, springs * 5000.0, follower.preload, x)
    assert np.max(np.abs(force / PAPER.force(x) - 1.0)) < 5e-3
    assert rolled_force(cam.cut_x, cam.cut_y, follower, x) == pytest.approx(PAPER.force(x), rel=5e-3)


def test_a_cam_cut_for_no_roller_misses_the_law_with_one():
    cam = cam_for(PAPER, Follower(roller_radius=0.0), 0.020)
    force = rolled_force(cam.cut_x, cam.cut_y, Follower(roller_radius=0.003), np.array([0.010]))
    assert abs(force[0] / PAPER.force(0.010) - 1.0) > 0.05


def test_a_point_follower_moves_along_the_surface():
    follower = Follower(roller_radius=0.0)
    cam = cam_for(PAPER, follower, 0.020)
    x = np.linspace(0.001, 0.019, 19)
    assert rolled_force(cam.cut_x, cam.cut_y, follower, x) == pytest.approx(PAPER.force(x), rel=2e-3)


def test_friction_is_compensated_while_loading_and_reduces_the_force_while_unloading():
    follower = Follower(friction=0.1)
    cam = cam_for(PAPER, follower, 0.020)
    x = np.linspace(0.0, 0.020, 21)
    assert rolled_force(cam.cut_x, cam.cut_y, follower, x) == pytest.approx(PAPER.force(x), rel=5e-3)
    angle, phi = np.arctan(cam.slope), math.atan(0.1)
    ratio = np.tan(angle - phi) / np.tan(angle + phi)
    assert cam.unloading_force == pytest.approx(ratio * PAPER.force(cam.deflection), rel=1e-6)


def test_force_of_an_undercut_cam_deviates_from_the_law():
    follower = Follower(preload=0.0005, roller_radius=0.003)
    cam = cam_for(PAPER, follower, 0.020)
    x = np.linspace(0.0, 0.020, 41)
    assert cam.largest_roller < 0.003
    assert np.max(np.abs(rolled_force(cam.cut_x, cam.cut_y, follower, x) / PAPER.force(x) - 1.0)) > 0.05


def test_the_largest_roller_is_where_the_cut_surface_starts_to_fold_back():
    radius = cam_for(PAPER, Follower(preload=0.0005, roller_radius=0.0), 0.020).largest_roller
    for share, folds in ((0.98, False), (1.02, True)):
        cam = cam_for(PAPER, Follower(preload=0.0005, roller_radius=share * radius), 0.020)
        assert bool(np.any(np.diff(cam.cut_x) < 0.0)) is folds


def test_the_least_preload_is_the_one_from_which_the_roller_fits():
    enough = least_preload(PAPER, Follower(preload=0.0002), 0.020)
    assert cam_for(PAPER, Follower(preload=1.01 * enough), 0.020).largest_roller > 0.003
    assert cam_for(PAPER, Follower(preload=0.98 * enough), 0.020).largest_roller < 0.003


def test_undercut_is_a_one_line_error_with_the_remedy(tmp_path, capsys):
    assert main(["--preload", "0.0005", "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    for word in ("undercut", "roller_radius = 0.003 m", "use a roller below 0.0016 m", "preload of at least"):
        assert word in error
    assert not (tmp_path / "out").exists()


def test_a_spring_that_pushes_at_rest_is_a_one_line_error_without_files(tmp_path, capsys):
    assert main(["--force-error", "1.0", "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "force_error = 1 1: the force at rest would be -" in error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("field", ["slope", "curvature"])
def test_a_cam_that_is_not_a_number_is_refused(field):
    cam = cam_for(PAPER, Follower(), 0.020)
    invalid = replace(cam, **{field: np.full_like(cam.slope, np.nan)})
    with pytest.raises(ConfigurationError):
        check_cuttable(PAPER, Follower(), invalid)


def test_the_command_prints_the_law_and_writes_the_profile(tmp_path, capsys):
    assert main(["--alpha", "1.3288", "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "F_S = 0.9772 exp(0.2658 x) + 1.2372" in text
    with (tmp_path / "design.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[-1]["deflection"]) == 0.020 and float(rows[-1]["force"]) == pytest.approx(200.0)
    surface = np.loadtxt(tmp_path / "cam_mm.csv", delimiter=",", skiprows=1)
    x = np.linspace(0.0, 0.020, 21)
    force = rolled_force(1e-3 * surface[:, 0], 1e-3 * surface[:, 1], Follower(), x)
    assert force == pytest.approx(PAPER.force(x), rel=5e-3)
    assert (tmp_path / "design.png").stat().st_size > 10_000
    assert "<svg" in (tmp_path / "design.svg").read_text()


def test_the_command_line_overrides_the_specification_file(tmp_path, capsys):
    spec = tmp_path / "stiff.yaml"
    spec.write_text("max_force: 300.0\nroller_radius: 0.002\n")
    assert main([str(spec), "--roller-radius", "0.004", "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "300 N at 20 mm" in text and "roller radius 4 mm" in text


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("max_force: -3.0\n", "max_force = -3.0 N: must be within"),
        ("max_fource: 3.0\n", "max_fource: no such parameter; did you mean max_force?"),
        ("- 1\n", "expected lines"),
        ("a: [\n", "spec.yaml"),
    ],
)
def test_an_invalid_specification_file_is_a_one_line_error_with_its_path(tmp_path, capsys, text, expected):
    spec = tmp_path / "spec.yaml"
    spec.write_text(text)
    assert main([str(spec), "--out", str(tmp_path)]) == 1
    error = capsys.readouterr().err
    assert "spec.yaml" in error and expected in error and error.count("\n") == 1


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"force_error": 3.0}, "force_error = 3 1: must be below 2.6"),
        ({"min_force": 250.0}, "min_force = 250 N: must be below max_force"),
        ({"rest_length": 0.03}, "rest_length = 0.03 m: must be below"),
    ],
)
def test_conditions_that_no_exponential_meets_are_refused(values, expected):
    with pytest.raises(ConfigurationError, match=expected):
        spring_from(Specification(**values))


def test_a_negative_offset_is_printed_as_such():
    wanted = Design()
    spring = ExponentialSpring(-1.0, 2.0, 200.0)
    assert "exp(0.2000 x) - 1.0000" in describe(wanted, spring, cam_for(spring, wanted, 0.020))
