# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Required figures and tables from entries with known figures."""

import json

import pytest
from vsa_bench.mismatch.bars import bars, best_peer
from vsa_bench.mismatch.table import pages
from vsa_common.terminal import markdown

GOOD = {"valid": 1.0, "error": 0.001, "coverage": 0.95, "wrong": 0.0, "half_width": 0.005}


def entry(case="spring_linear", group="springs", stiffness=(), damping=(), peers=(("menard", 0.01),), seconds=5.0):
    median = {
        "stiffness": GOOD | dict(stiffness), "damping": GOOD | dict(damping), "inertia": GOOD, "peers": dict(peers),
        "time_to_5pct_s": seconds, "converged": float(seconds is not None), "dropped": 0.0,
    }  # fmt: skip
    return {
        "case": case, "group": group, "motion": "mix", "rate_hz": 100, "seeds": [1],
        "runs": [{"time_to_5pct_s": seconds}], "median": median,
    }  # fmt: skip


def by_name(cases):
    return {bar.quantity: bar for bar in bars(cases)}


def test_good_figures_reach_every_bar():
    found = by_name([entry(), entry("crosstalk", "sensors")])
    assert len(found) == 13
    assert all(bar.reached for bar in found.values())


@pytest.mark.parametrize(
    ("quantity", "change"),
    [
        ("stiffness: valid and wrong", {"stiffness": {"wrong": 0.006}}),
        ("damping: valid and wrong", {"damping": {"wrong": 0.006}}),
        ("stiffness: coverage", {"stiffness": {"coverage": 0.89}}),
        ("damping: coverage", {"damping": {"coverage": 0.89}}),
        ("springs: stiffness error", {"stiffness": {"error": 0.004}}),
        ("springs: stiffness valid", {"stiffness": {"valid": 0.85}}),
        ("springs: error over the best peer's", {"peers": {"menard": 0.01, "grioli_bicchi": 0.0009}}),
        ("springs: half-width", {"stiffness": {"half_width": 0.011}}),
        ("converged", {"seconds": None}),
    ],
)
def test_the_worst_case_of_a_missed_bar_is_named(quantity, change):
    bar = by_name([entry("spring_sinh"), entry("spring_stop", **change), entry("spring_cubic")])[quantity]
    assert (bar.reached, bar.missed, bar.cases) == (False, 1, 3)
    assert bar.worst == "spring_stop mix 100 Hz"


def test_mean_coverage_has_a_band_and_the_mean_time_a_limit():
    cases = [entry(stiffness={"coverage": 1.0}), entry(stiffness={"coverage": 0.99}, seconds=12.0)]
    found = by_name(cases)
    assert not found["stiffness: mean coverage"].reached
    assert found["stiffness: mean coverage"].figure == "0.995"
    assert found["seconds to 5 %"].figure == "8.5"
    assert not found["seconds to 5 %"].reached


def test_limits_of_springs_do_not_apply_to_sensors():
    found = by_name([entry("crosstalk", "sensors", stiffness={"error": 0.02, "half_width": 0.02, "valid": 0.1})])
    assert not [name for name in found if name.startswith("springs")]
    assert found["sensors: half-width"].reached


def test_a_quantity_that_is_never_valid_has_no_coverage_to_reach():
    found = by_name([entry(damping={"coverage": None}), entry()])
    assert found["damping: coverage"].cases == 1


def test_the_best_peer_has_the_least_error():
    assert best_peer(entry(peers={"menard": 0.02, "grioli_bicchi": None, "other": 0.01})) == ("other", 0.01)
    assert best_peer(entry(peers={"menard": None})) is None


def test_the_worst_row_is_the_worst_of_the_motions():
    cases = [
        entry(stiffness={"error": 0.02, "valid": 0.9}, seconds=3.0),
        entry(stiffness={"coverage": 0.5}, peers={"menard": 0.05}, seconds=7.0),
    ]
    (page,) = (one for one in pages({"cases": cases, "recorded": []}) if one.title.startswith("worst"))
    assert page.rows == [
        ["spring_linear", "menard", "5.00", "90", "2.00", "0.50", "0.00", "0.50", "7.0",
         "100", "0.10", "0.95", "0.00", "0.50"]
    ]  # fmt: skip


def test_the_markdown_has_every_table_with_full_rows():
    recorded = [
        {
            "recording": "a.csv",
            "start": "default",
            "reference": "truth",
            "points": 3,
            "stiffness": GOOD,
        }
    ]
    report = json.loads(json.dumps({"cases": [entry(), entry("crosstalk", "sensors")], "recorded": recorded}))
    text = markdown(pages(report))
    assert [line for line in text.splitlines() if line.startswith("#")] == [
        "### Springs", "### Sensors", "### Worst of the motions and rates", "### Required figures",
        "### Real recordings: stiffness",
    ]  # fmt: skip
    for section in text.split("### ")[1:]:
        widths = {line.count("|") for line in section.splitlines() if line.startswith("|")}
        assert len(widths) == 1
    assert "| a.csv | default | truth | 3 | 100 | 0.10 | 0.95 | 0.00 | 0.50 |" in text
