"""`./vsa bench estimation|live|joint|ablation|view|soak`: figures of the suite, each with its reference."""

import importlib
import sys

BENCHES = {
    "estimation": "the estimators and their peers on simulated recordings",
    "live": "the whole suite, running",
    "joint": "the joint's impedance against the simulated joint's response",
    "ablation": "half and double of each tuned constant of the estimator",
    "view": "what the live page costs: processor time, and delay of the nodes with and without it",
    "soak": "random frames, hours through the filter, the whole suite with its memory watched",
}


def main(argv: list[str] | None = None) -> int:
    """Run the bench that the first argument names with the rest of the arguments; its exit code."""
    arguments = sys.argv[1:] if argv is None else argv
    if not arguments or arguments[0] not in BENCHES:
        asked_for_help = bool(arguments) and arguments[0] in ("-h", "--help")
        listing = "\n".join(f"  {name:<12}{text}" for name, text in BENCHES.items())
        print(
            f"usage: bench NAME [ARGS]    (bench NAME --help tells more)\n\n{listing}",
            file=sys.stdout if asked_for_help else sys.stderr,
        )
        return 0 if asked_for_help else 2
    module = importlib.import_module(f"vsa_bench.{arguments[0]}.command")
    return int(module.main(arguments[1:]) or 0)


if __name__ == "__main__":
    sys.exit(main())
