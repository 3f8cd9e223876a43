# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Spring constants of a recording by numpy: a fit of ln(stiffness) over deflection beside the estimator's k2.

python examples/analyse.py vsa_demo/bag
"""

import sys

import numpy as np
from vsa_common.figures import SIDES, panels, save
from vsa_common.io.bags import BagError, read


def columns(bag: str, topic: str, *names: str) -> dict[str, np.ndarray]:
    """Fields of a topic's messages as arrays, SI."""
    rows = [[getattr(message, name) for name in names] for _, _, message in read(bag, [topic])]
    return dict(zip(names, np.array(rows, dtype=float).reshape(-1, len(names)).T, strict=True))


def main(bag: str) -> int:
    figure, axes = panels(1, 1, height=3.0, title="stiffness over deflection")
    for i, color in zip((1, 2), SIDES, strict=True):
        side = columns(bag, f"/vsa/transmission_{i}/impedance", "deflection", "stiffness", "stiffness_valid")
        state = columns(bag, f"/vsa/transmission_{i}/estimator_state", "k2", "k2_variance", "k2_valid")
        valid = side["stiffness_valid"] == 1.0
        known = np.flatnonzero(state["k2_valid"])
        if valid.sum() < 2 or not known.size:
            print(f"transmission_{i}: stiffness or k2 was never valid in {bag}")
            continue
        last = np.flatnonzero(valid)[valid.sum() // 2 :]  # the second half, after initialization
        x, sigma = side["deflection"][last], side["stiffness"][last]
        slope, level = np.polyfit(x, np.log(sigma), 1)
        k2, half = state["k2"][known[-1]], 1.96 * np.sqrt(state["k2_variance"][known[-1]])
        low, high = 1e-3 * sigma.min(), 1e-3 * sigma.max()
        print(f"transmission_{i}: {valid.mean():.0%} of the time valid, stiffness {low:.2f} to {high:.2f} N/mm")
        print(f"  k2 {1e-3 * slope:.4f} /mm by this fit, {1e-3 * k2:.4f} +- {1e-3 * half:.4f} /mm by the estimator")
        axes.plot(1e3 * x, 1e-3 * sigma, ".", color=color, markersize=1.0, label=f"transmission {i}")
        along = np.linspace(x.min(), x.max())
        axes.plot(1e3 * along, 1e-3 * np.exp(level + slope * along), color="black", linewidth=0.8)
    joint = columns(bag, "/vsa/joint_impedance", "stiffness", "stiffness_valid", "co_contraction")
    usable = joint["stiffness_valid"] == 1.0
    if usable.any():
        gain = np.corrcoef(joint["co_contraction"][usable], joint["stiffness"][usable])[0, 1]
        print(f"joint: K follows the co-contraction with a correlation of {gain:.3f}")
    axes.set(xlabel="deflection [mm]", ylabel="stiffness [N/mm]")
    save(figure, "analysis.png")
    print("wrote analysis.png")
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        sys.exit(main(sys.argv[1]))
    except BagError as error:
        sys.exit(f"analyse: {error}")
