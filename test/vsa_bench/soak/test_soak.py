# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Short versions of `./vsa bench soak`."""

import json

import pytest
from vsa_bench.command import main
from vsa_bench.soak import live
from vsa_bench.soak.command import out_of_bounds
from vsa_bench.soak.filter import soak_filter, soak_frames
from vsa_common.ros.subprocesses import ProcessError


def test_random_frames_give_only_valid_outputs():
    figures = soak_frames(20_000)
    assert figures["unsound"] == 0
    assert out_of_bounds({"frames": figures}) == []


def test_the_covariance_stays_valid_over_five_minutes_of_motion():
    figures = soak_filter(5.0 / 60.0)
    assert figures["samples_fused"] == 7_500
    assert (figures["unsound"], figures["wrong_but_valid"], figures["resets"]) == (0, 0, 0)
    assert figures["worst_stiffness_error"] < 0.01
    assert out_of_bounds({"filter": figures}) == []


def test_growth_and_losses_are_out_of_bounds():
    live = {"samples_lost": 3, "rss_growth_mb": {"joint": 25.0, "driver": 1.0}, "descriptors_growth": {"driver": 2}}
    texts = ["live: samples_lost 3", "live: joint grew by 25.0 MB", "live: driver opened 2 descriptors"]
    assert out_of_bounds({"live": live}) == texts


def test_figures_are_written_before_the_running_suite_fails(tmp_path, monkeypatch):
    def fail(seconds):
        raise ProcessError("joint ended with code 1")

    monkeypatch.setattr(live, "soak_live", fail)
    path = tmp_path / "soak.json"
    with pytest.raises(ProcessError):
        main(["soak", "--frames", "2000", "--hours", "0", "--live", "1", "--json", str(path)])
    assert json.loads(path.read_text())["frames"]["frames"] == 2000


def test_the_command_without_a_part_is_within_bounds(capsys):
    assert main(["soak", "--frames", "0", "--hours", "0", "--live", "0"]) == 0
    assert "within bounds" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["soak", "--hours", "many"])
