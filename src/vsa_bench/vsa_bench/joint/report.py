# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Table, summary and JSON of the outcomes."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from vsa_bench.joint.experiment import Outcome
from vsa_joint.impedance.reflection import Impedance

HEADER = (
    "friction", "tendon", "force", "torque", "identified K", "D", "estimated K", "D", "(13) D", "response",
)  # fmt: skip
NOTE = (
    "friction of each transmission in N; tendon in N/mm; force while held in N; torque in mN m rms. Identified: "
    "against truth; estimated: against identified; largest error over the seeds.\n(13) D: damping as printed over the "
    "true one. response: largest error over 0.05 to 20 Hz. *: the expansion is not valid up to 0.65 Hz."
)
NAMES = ("stiffness", "damping")
PERCENT = 100.0
INTERVAL = 1.96  # standard deviations


def rows(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """One row per friction, tendon and force."""
    groups: dict[tuple[float, float, float], list[Outcome]] = {}
    for o in outcomes:
        groups.setdefault((o.case.coulomb_friction, o.case.tendon_stiffness, o.case.force), []).append(o)
    out = []
    for (friction, tendon, force), group in groups.items():
        responses = [o.response.error for o in group if o.response]
        out.append(
            [
                f"{friction:g}",
                f"{tendon * 1e-3:g}{'' if group[0].expansion_valid else ' *'}",
                f"{force:g}",
                f"{np.mean([o.torque_rms for o in group]) * 1e3:.0f}",
                *(_largest(relative_error(o.identified.impedance, o.truth, name) for o in group) for name in NAMES),
                *(_largest(relative_error(o.estimated, o.identified.impedance, name) for o in group) for name in NAMES),
                f"{np.mean([o.printed.damping / o.truth.damping for o in group]):.2f}",
                f"{PERCENT * max(responses):.2f} %" if responses else "",
            ]
        )
    return out


def summary(outcomes: Sequence[Outcome]) -> str:
    """Largest errors and coverage of the intervals, one per line."""
    lines = []
    for name, chosen in (
        ("without friction", [o for o in outcomes if o.case.frictionless]),
        ("with friction", [o for o in outcomes if not o.case.frictionless]),
    ):
        if not chosen:
            continue
        valid = [o for o in chosen if o.expansion_valid] if chosen[0].case.frictionless else chosen
        lines.append(f"{name}, {len(chosen)} cases, largest error:")
        if chosen[0].case.frictionless:
            lines.append(f"  response {PERCENT * max(o.response.error for o in chosen if o.response):.2f} %")
        else:
            lines.append("  identified against truth: " + _errors(chosen, lambda o: (o.identified.impedance, o.truth)))
        lines.append(
            "  estimated against identified: " + _errors(valid, lambda o: (o.estimated, o.identified.impedance))
        )
        shares = {
            what: ", ".join(f"{name} {np.mean([covers(o, name) for o in chosen]):.0%}" for name in NAMES)
            for what, covers in (("identified", identified_covers), ("estimated", estimated_covers))
        }
        lines.append(
            "  coverage of the 95 % intervals: " + "; ".join(f"{what} {share}" for what, share in shares.items())
        )
    return "\n".join(lines)


def case_json(o: Outcome) -> dict[str, Any]:
    """One case of the JSON file."""
    return {
        "co_contraction": o.co_contraction,
        "rod_force_n": o.case.force,
        "tendon_n_per_m": o.case.tendon_stiffness,
        "coulomb_friction": o.case.coulomb_friction,
        "amplitude_nm": o.torque_rms,
        "seed": o.case.seed,
        "spring": o.case.spring,
        "expansion_valid": o.expansion_valid,
        "identified": asdict(o.identified.impedance),
        "identified_std": asdict(o.identified.std),
        "estimated": asdict(o.estimated),
        "estimated_std": asdict(o.estimated_std),
        "consistent": asdict(o.truth),
        "paper": asdict(o.printed),
        "response_error": o.response.error if o.response else None,
        "interval_holds": {name: identified_covers(o, name) for name in NAMES},
        "estimated_interval_holds": {name: estimated_covers(o, name) for name in NAMES},
    }


def identified_covers(o: Outcome, name: str) -> bool:
    """Whether the 95 % interval of the experiment contains the rig's truth."""
    return _covers(o.identified.impedance, o.identified.std, o.truth, name)


def estimated_covers(o: Outcome, name: str) -> bool:
    """Whether the 95 % interval of the estimate contains the rig's truth."""
    return _covers(o.estimated, o.estimated_std, o.truth, name)


def relative_error(value: Impedance, reference: Impedance, name: str) -> float:
    """Relative error of stiffness, damping or inertia."""
    return float(getattr(value, name) / getattr(reference, name) - 1.0)


def _covers(value: Impedance, std: Impedance, truth: Impedance, name: str) -> bool:
    return bool(abs(getattr(value, name) - getattr(truth, name)) <= INTERVAL * getattr(std, name))


def _largest(errors: Iterable[float]) -> str:
    return f"{PERCENT * max(errors, key=abs):+.2f} %"


def _errors(outcomes: Sequence[Outcome], pair: Callable[[Outcome], tuple[Impedance, Impedance]]) -> str:
    if not outcomes:
        return "the expansion is valid in no case"
    parts = []
    for name in NAMES:
        errors = [abs(relative_error(value, reference, name)) for value, reference in map(pair, outcomes)]
        parts.append(f"{name} {PERCENT * max(errors):.2f} %")
    return ", ".join(parts)
