# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`./vsa bench ablation`: what half and double of each tuned constant of the estimator do to its estimates."""

import argparse
import json
import multiprocessing
import os
import sys
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict
from pathlib import Path

from vsa_bench.ablation.groups import GROUPS, groups_of, sources_of
from vsa_bench.ablation.report import HEADER, NOTE, Effect, Row, as_json, chosen, collect, effect, markdown, table
from vsa_bench.ablation.trial import PACKAGE, Source, Trial, TrialError, initialize_worker, run_trial
from vsa_bench.ablation.variation import FACTORS, Variation, declared, vary
from vsa_common.fork import killed_with
from vsa_common.terminal import progress, show_table


def main(argv: list[str] | None = None) -> int:
    """Run the command; its exit code."""
    options = _arguments(argv)
    constants = declared(PACKAGE)
    variations = [
        one for module, constant in chosen(constants, options.only) for factor in FACTORS
        if (one := vary(module, constant, factor))
    ]  # fmt: skip
    if not variations:
        print(f"bench ablation: no tuned constant of {PACKAGE} is chosen", file=sys.stderr)
        return 1
    begin = time.monotonic()
    try:
        bases, effects = evaluate(variations, options)
    except (BrokenProcessPool, TrialError) as error:
        print(f"bench ablation: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("bench ablation: stopped", file=sys.stderr)
        return 130
    minutes = (time.monotonic() - begin) / 60.0
    rows = collect(constants, effects, options.only)
    count = sum(len(base.figures) for base in bases.values())
    title = f"{len(rows)} constants, {len(variations)} variations, {count} recordings, {minutes:.1f} min"
    show_table(title, HEADER, table(rows), NOTE, texts=2)
    if options.json:
        _write(options.json, json.dumps(_report(rows, bases, minutes), indent=1) + "\n")
    if options.markdown:
        command = " ".join(["./vsa bench ablation", *(["--quick"] if options.quick else [])])
        _write(options.markdown, markdown(rows, "Ablation of the tuned constants") + f"\n{title}: `{command}`.\n")
    return 0


def evaluate(variations: Sequence[Variation], options: argparse.Namespace) -> tuple[dict[str, Trial], list[Effect]]:
    """The trials with the tuned values by group of recordings, and one effect of each variation.

    A constant that changes no output of a group is tried on the next one of its module. Raises as `ablate`.
    """
    bases: dict[str, Trial] = {}
    effects: dict[Variation, Effect] = {}
    for group in GROUPS:
        effective = {(e.variation.module, e.variation.name) for e in effects.values() if e.bits_changed}
        due = [
            one for one in variations
            if group in (options.group or groups_of(one.module)) and (one.module, one.name) not in effective
        ]  # fmt: skip
        if due:
            sources = list(sources_of(group, options.quick, options.seconds))
            bases[group], found = ablate(sources, due, options.processes)
            effects.update((one.variation, one._replace(group=group)) for one in found)
    return bases, list(effects.values())


def ablate(sources: Sequence[Source], variations: Sequence[Variation], processes: int) -> tuple[Trial, list[Effect]]:
    """The trial with the tuned values, and the effect of each variation against it.

    Raises TrialError where the estimator fails with the tuned values, BrokenProcessPool where a worker is killed.
    """
    durations = {one.name: 1e-9 * float(one.stamps_ns[-1] - one.stamps_ns[0]) for one in sources}
    fork = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(processes, fork, _initialize, (os.getpid(), sources)) as pool:
        base = pool.submit(run_trial, {})
        pending = {pool.submit(run_trial, one.overrides): one for one in variations}
        try:
            with progress(1 + len(pending), "tuned values", count=True) as bar:
                reference = base.result()
                if reference.failure:
                    raise TrialError(f"with the tuned values: {reference.failure}")
                bar.advance(1)
                effects = []
                for done in as_completed(pending):
                    variation = pending[done]
                    effects.append(effect(variation, reference, done.result(), durations))
                    bar.advance(1, variation.name)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return reference, effects


def _initialize(parent: int, sources: Sequence[Source]) -> None:
    killed_with(parent)
    initialize_worker(sources)


def _report(rows: Sequence[Row], bases: Mapping[str, Trial], minutes: float) -> dict[str, object]:
    return {
        "minutes": round(minutes, 1),
        "recordings": {
            group: {name: asdict(figures) for name, figures in base.figures.items()} for group, base in bases.items()
        },
        "constants": [as_json(row) for row in rows],
    }


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench ablation",
        description="Half and double of each tuned constant of the estimator, within its permitted range: the change "
        "of errors, coverage, convergence, validity and resets on the same simulated recordings. In plain Python.",
    )
    parser.add_argument("--quick", action="store_true", help="few short recordings: about 10 s a variation")
    parser.add_argument(
        "--group", nargs="+", default=[], choices=GROUPS, help="recordings to use (default: those of the module)"
    )
    parser.add_argument(
        "--only", nargs="+", default=[], metavar="NAME", help="constants, modules of constants, or module.CONSTANT"
    )
    parser.add_argument("--seconds", type=float, metavar="S", help="of each recording (60; 15 to 20 with --quick)")
    parser.add_argument(
        "--processes", type=int, default=len(os.sched_getaffinity(0)), metavar="N", help="at once (%(default)s)"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="all figures of all variations")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="the table as Markdown")
    return parser.parse_args(argv)


if __name__ == "__main__":
    sys.exit(main())
