# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench NAME`: figures of the suite, each with its reference."""

import importlib
import sys

BENCHES = {
    "estimation": "estimators, peers and the Cramer-Rao bound on simulated recordings",
    "mismatch": "estimator and peers where transmission or sensors are not the paper's; real recordings",
    "faults": "detection, isolation and recovery of each fault; false alarms on healthy motion",
    "live": "rate, delay and cost of the running suite",
    "joint": "the joint's impedance against the simulated joint's response",
    "ablation": "half and double of each tuned constant of the estimator",
    "view": "processor time of the live page, and delay of the nodes with and without it",
    "soak": "random frames, hours through the filter, memory of the running suite",
}


def main(argv: list[str] | None = None) -> int:
    """Run the bench that the first argument names with the rest of the arguments; its exit code."""
    arguments = sys.argv[1:] if argv is None else argv
    if not arguments or arguments[0] not in BENCHES:
        asked_for_help = bool(arguments) and arguments[0] in ("-h", "--help")
        listing = "\n".join(f"  {name:<12}{text}" for name, text in BENCHES.items())
        print(
            f"usage: bench NAME [ARGS]    (options: bench NAME --help)\n\n{listing}",
            file=sys.stdout if asked_for_help else sys.stderr,
        )
        return 0 if asked_for_help else 2
    module = importlib.import_module(f"vsa_bench.{arguments[0]}.command")
    return int(module.main(arguments[1:]) or 0)


if __name__ == "__main__":
    sys.exit(main())
