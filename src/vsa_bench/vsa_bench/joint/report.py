"""Table and JSON of the experiment's outcomes."""

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
    "friction of each rod in N; tendon in N/mm; rod force held in N; torque in mN m rms. Identified: against the rig; "
    "estimated: against the identified; worst of the seeds.\n(13) D: damping as printed over the true one. "
    "response: worst of 0.05 to 20 Hz. *: the expansion does not hold up to 0.65 Hz."
)
NAMES = ("stiffness", "damping")
PERCENT = 100.0
INTERVAL = 1.96  # standard deviations


def rows(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """One row for each friction, tendon and force."""
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
                *(_worst(relative_error(o.identified.impedance, o.truth, name) for o in group) for name in NAMES),
                *(_worst(relative_error(o.estimated, o.identified.impedance, name) for o in group) for name in NAMES),
                f"{np.mean([o.printed.damping / o.truth.damping for o in group]):.2f}",
                f"{PERCENT * max(responses):.2f} %" if responses else "",
            ]
        )
    return out


def summary(outcomes: Sequence[Outcome]) -> str:
    """The figures that the bench is for, one a line."""
    lines = []
    for name, chosen in (
        ("without friction", [o for o in outcomes if o.case.frictionless]),
        ("with friction", [o for o in outcomes if not o.case.frictionless]),
    ):
        if not chosen:
            continue
        valid = [o for o in chosen if o.expansion_valid] if chosen[0].case.frictionless else chosen
        lines.append(f"{name}, {len(chosen)} cases, worst error:")
        if chosen[0].case.frictionless:
            lines.append(f"  response {PERCENT * max(o.response.error for o in chosen if o.response):.2f} %")
        else:
            lines.append("  identified of the truth: " + _pair(chosen, lambda o: (o.identified.impedance, o.truth)))
        lines.append("  estimated of the identified: " + _pair(valid, lambda o: (o.estimated, o.identified.impedance)))
        shares = {
            what: ", ".join(f"{name} {np.mean([holds(o, name) for o in chosen]):.0%}" for name in NAMES)
            for what, holds in (("identified", identified_holds), ("estimated", estimated_holds))
        }
        lines.append("  95 % intervals that hold: " + "; ".join(f"{what} {share}" for what, share in shares.items()))
    return "\n".join(lines)


def case_json(o: Outcome) -> dict[str, Any]:
    """One case for the JSON file."""
    return {
        "co_contraction": o.co_contraction,
        "rod_force_n": o.case.force,
        "tendon_n_per_m": o.case.tendon_stiffness,
        "coulomb_friction": o.case.coulomb_friction,
        "amplitude_nm": o.torque_rms,
        "seed": o.case.seed,
        "expansion_valid": o.expansion_valid,
        "identified": asdict(o.identified.impedance),
        "identified_std": asdict(o.identified.std),
        "estimated": asdict(o.estimated),
        "estimated_std": asdict(o.estimated_std),
        "consistent": asdict(o.truth),
        "paper": asdict(o.printed),
        "response_error": o.response.error if o.response else None,
        "interval_holds": {name: identified_holds(o, name) for name in NAMES},
        "estimated_interval_holds": {name: estimated_holds(o, name) for name in NAMES},
    }


def identified_holds(o: Outcome, name: str) -> bool:
    """Whether the experiment's 95 % interval contains the rig's truth."""
    return _holds(o.identified.impedance, o.identified.std, o.truth, name)


def estimated_holds(o: Outcome, name: str) -> bool:
    """Whether the estimate's 95 % interval contains the rig's truth."""
    return _holds(o.estimated, o.estimated_std, o.truth, name)


def relative_error(value: Impedance, reference: Impedance, name: str) -> float:
    """Of stiffness, damping or inertia."""
    return float(getattr(value, name) / getattr(reference, name) - 1.0)


def _holds(value: Impedance, std: Impedance, truth: Impedance, name: str) -> bool:
    return bool(abs(getattr(value, name) - getattr(truth, name)) <= INTERVAL * getattr(std, name))


def _worst(errors: Iterable[float]) -> str:
    return f"{PERCENT * max(errors, key=abs):+.2f} %"


def _pair(outcomes: Sequence[Outcome], of: Callable[[Outcome], tuple[Impedance, Impedance]]) -> str:
    if not outcomes:
        return "the expansion holds in no case"
    parts = []
    for name in NAMES:
        errors = [abs(relative_error(value, reference, name)) for value, reference in map(of, outcomes)]
        parts.append(f"{name} {PERCENT * max(errors):.2f} %")
    return ", ".join(parts)
