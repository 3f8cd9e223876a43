"""Short versions of `./vsa bench soak`."""

import pytest
from vsa_bench.command import main
from vsa_bench.soak.command import faults
from vsa_bench.soak.filter import soak_filter, soak_frames


def test_twenty_thousand_random_frames_leave_nothing_unsound():
    figures = soak_frames(20_000)
    assert figures["unsound"] == 0
    assert faults({"frames": figures}) == []


def test_five_minutes_of_motion_leave_the_filter_sound():
    figures = soak_filter(5.0 / 60.0)
    assert figures["samples_fused"] == 7_500
    assert (figures["unsound"], figures["wrong_but_valid"], figures["resets"]) == (0, 0, 0)
    assert figures["worst_stiffness_error"] < 0.01
    assert faults({"filter": figures}) == []


def test_what_grows_or_is_lost_is_said():
    live = {"samples_lost": 3, "rss_growth_mb": {"joint": 25.0, "driver": 1.0}, "descriptors_growth": {"driver": 2}}
    said = ["live: samples_lost 3", "live: joint grew by 25.0 MB", "live: driver opened 2 descriptors"]
    assert faults({"live": live}) == said


def test_the_command_is_found_and_nothing_to_do_is_nothing_amiss(capsys):
    assert main(["soak", "--frames", "0", "--hours", "0", "--live", "0"]) == 0
    assert "nothing amiss" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["soak", "--hours", "many"])
