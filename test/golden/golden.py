# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Golden traces: the same samples must give the same estimates, equal to the bit.

    ./vsa golden check      compare with traces.json; exit code 1 and one line for each difference
    ./vsa golden renew      write traces.json; the commit message gives the reason of the change

A trace is the hash of every output row, of the state once a second and at the end, and of the samples themselves; with
numba, and in plain Python (VSA_NO_NUMBA) over the first seconds. On another processor or with other libraries the last
bits differ; then the sums stored with each trace are compared within TOLERANCE.
"""

import argparse
import hashlib
import json
import os
import pickle
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

import numpy as np

TRACES = Path(__file__).parent / "traces.json"
TOLERANCE = 1e-6  # relative, on another machine
PLAIN_SAMPLES = 2400  # per recording without numba
CHUNK = 700  # samples per call of `add_many`


def estimate(recording) -> dict[str, np.ndarray]:
    """Rows by `add`, then by `add_many`, predictions in silence, and states, of one recording."""
    from chain import numbers
    from vsa_estimator.formulations import create_estimator

    _, config, stamps, force, deflection = recording
    estimator, rows, states, predictions = create_estimator(config), [], [], []
    half = len(stamps) // 2
    next_state = int(stamps[0])
    for one in zip(stamps[:half].tolist(), force[:half].tolist(), deflection[:half].tolist(), strict=True):
        estimate = estimator.add(*one)
        rows.append(np.full(34, np.nan) if estimate is None else np.array(numbers(estimate)))
        if one[0] >= next_state:
            next_state = one[0] + 1_000_000_000
            states.append(numbers(estimator.state()))
    for begin in range(half, len(stamps), CHUNK):
        part = slice(begin, begin + CHUNK)
        many = estimator.add_many(stamps[part], force[part], deflection[part])
        rows.append(many.view("f8"))
        states.append(numbers(estimator.state()))
    for silence_ns in (1_000_000, 20_000_000, 300_000_000):
        predictions.append(numbers(estimator.predict_to(int(np.max(stamps[-20:])) + silence_ns)))
    return {
        "samples": np.concatenate([stamps.astype(float), force, deflection]),
        "rows": np.concatenate([row.ravel() for row in rows]),
        "states": np.concatenate([np.array(state) for state in states]),
        "predictions": np.array(predictions),
    }


def recorded() -> Iterator[object]:
    """All recordings; the simulated rig is slow without numba."""
    import recordings

    for source in recordings.SOURCES:
        yield from source()


def write_beginnings(path: Path) -> None:
    """Write the first seconds of the recordings, for the process without numba."""
    beginnings = []
    for one in recorded():
        part = {name: getattr(one, name)[:PLAIN_SAMPLES] for name in ("stamps_ns", "force", "deflection")}
        if not one.name.startswith("faults_500"):
            beginnings.append(one._replace(**part))
    path.write_bytes(pickle.dumps(beginnings))


def _jobs(beginnings: Path | None) -> Iterator[tuple[str, str, object]]:
    for recording in recorded() if beginnings is None else pickle.loads(beginnings.read_bytes()):
        yield recording.name, "recording", recording
    if beginnings is None:
        yield "chain", "chain", None
        yield "stored_run", "stored_run", None


def _trace(job: tuple[str, str, object]) -> tuple[str, dict[str, object]]:
    name, kind, argument = job
    if kind == "recording":
        arrays = estimate(argument)
    elif kind == "chain":
        import chain

        arrays = chain.run()
    else:
        import stored_run

        arrays = stored_run.figures()
    return name, {key: [_hash(array), _numbers(array)] for key, array in arrays.items()}


def _hash(array: np.ndarray) -> str:
    array = np.where(np.isnan(array), np.nan, array) + 0.0  # one NaN, one zero
    return hashlib.sha256(np.ascontiguousarray(array, dtype="<f8").tobytes()).hexdigest()[:20]


def _numbers(array: np.ndarray) -> list[float]:
    """Sums for the comparison on another machine."""
    finite = array[np.isfinite(array)].ravel()
    size = np.sign(finite) * np.log1p(np.abs(finite))  # equal weight for fields of all orders of magnitude
    return [float(array.size), float(finite.size), float(size.sum()), float(np.abs(size).sum())]


def traces(beginnings: Path | None, only: list[str]) -> dict[str, dict[str, object]]:
    """All traces, computed by this process; of the recordings in the file `beginnings` without numba."""
    found: dict[str, dict[str, object]] = {}
    jobs = (job for job in _jobs(beginnings) if not only or job[0] in only)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for name, trace in pool.map(_trace, jobs):
            found[name] = trace
            if sys.stderr.isatty():
                print(f"\r{len(found)} traces", end="", file=sys.stderr)
    return found


def machine() -> str:
    """Processor and libraries, on which the last bits depend."""
    import numba
    import scipy

    cpu = next((line for line in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in line), "")
    libraries = f"numpy {np.__version__}, scipy {scipy.__version__}, numba {numba.__version__}"
    core = os.environ.get("OPENBLAS_CORETYPE", "")
    return f"{platform.machine()} {cpu.rpartition(': ')[2]} {core}, Python {platform.python_version()}, {libraries}"


def differences(golden: dict, found: dict, same_machine: bool) -> Iterator[str]:
    """One line for each trace that differs."""
    for name, trace in found.items():
        for key, (digest, numbers) in trace.items():
            before = golden.get(name, {}).get(key)
            if before is None:
                yield f"{name} {key}: no golden trace"
            elif same_machine and digest != before[0]:
                yield f"{name} {key}: differs ({_relative(before[1], numbers):.1e})"
            elif not same_machine and not _relative(before[1], numbers) < TOLERANCE:
                yield f"{name} {key}: off by {_relative(before[1], numbers):.1e}, more than {TOLERANCE:.0e}"
        for key in golden.get(name, {}).keys() - trace.keys():
            yield f"{name} {key}: missing"


def _relative(before: list[float], now: list[float]) -> float:
    before, now = np.array(before), np.array(now)
    return float(np.max(np.abs(now - before) / np.maximum(np.abs(before), 1e-300), initial=0.0))


def _of_mode(mode: str, only: list[str]) -> dict[str, dict[str, object]]:
    """Traces of a mode, computed by a process in that mode."""
    environment = {key: value for key, value in os.environ.items() if key != "VSA_NO_NUMBA"}
    with tempfile.TemporaryDirectory() as temporary:
        out, beginnings = Path(temporary, "traces.json"), Path(temporary, "beginnings")
        compute = [sys.executable, __file__, "compute", "--out", str(out), *(["--only", *only] if only else [])]
        if mode == "plain":
            write = [sys.executable, __file__, "record", "--beginnings", str(beginnings)]
            subprocess.run(write, env=environment, check=True)
            environment["VSA_NO_NUMBA"] = "1"
            compute += ["--beginnings", str(beginnings)]
        if subprocess.run(compute, env=environment, stdout=subprocess.DEVNULL, check=False).returncode:
            raise SystemExit(f"golden: the {mode} traces failed")
        return json.loads(out.read_text())


def main() -> int:
    """Run the command; its exit code."""
    parser = argparse.ArgumentParser(prog="golden", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "action", choices=["check", "renew", "compute", "record"], help="compute and record: steps of check and renew"
    )
    parser.add_argument("--out", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--beginnings", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--mode", choices=["numba", "plain", "both"], default="both")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="names of recordings, chain, stored_run")
    options = parser.parse_args()
    if options.action == "compute":
        options.out.write_text(json.dumps(traces(options.beginnings, options.only)))
        return 0
    if options.action == "record":
        write_beginnings(options.beginnings)
        return 0
    modes = ["numba", "plain"] if options.mode == "both" else [options.mode]
    golden = json.loads(TRACES.read_text()) if TRACES.exists() else {"machine": "", "numba": {}, "plain": {}}
    same_machine = golden["machine"] == machine()
    wrong, count = [], 0
    for mode in modes:
        begin = time.monotonic()
        found = _of_mode(mode, options.only)
        count += len(found)
        if options.action == "renew":
            golden[mode] = {**golden[mode], **found} if options.only else found
        else:
            wrong += [f"{mode}: {line}" for line in differences(golden[mode], found, same_machine)]
        print(f"golden: {len(found)} {mode} traces in {time.monotonic() - begin:.0f} s", file=sys.stderr)
    if options.action == "renew":
        TRACES.write_text(json.dumps(golden | {"machine": machine()}, indent=1) + "\n")
        print(f"golden: wrote {TRACES}")
        return 0
    for line in wrong:
        print(line)
    how = "to the bit" if same_machine else f"within {TOLERANCE:.0e} (other machine or libraries)"
    print(f"golden: {count} traces, {len(wrong)} differences" + f"; equal {how}" * (not wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
