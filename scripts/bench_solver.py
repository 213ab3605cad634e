"""Measure the exact solver against ASPHER, Tamaas and ContactMechanics, in one run.

    python scripts/bench_solver.py [--surface NAME ...] [--rounds 3] [--seconds 120]

A curve of 16 loads p/E* = 1e-4 … 0.1 on one self-affine surface, H = 0.7, rms slope 0.1.
roughbench solves the whole curve at its default tolerance, 1e-6, and computes the
stiffness at every load; the peers compute none. A peer solves as many of the loads as
fit into ``--seconds``, spread over the curve, and the ratio compares the time for just
these loads. The codes take turns, A B C A B C.

Tolerances mean different things: each peer gets the loosest of 1e-6, 1e-7 … with which
its certificate, recomputed here in float64 from the returned pressure, is about as good
as roughbench's; the table shows it. The peers live in ``.venv-peers``, which this script
makes. Building ASPHER takes a C++17 compiler, CMake and Eigen (Debian: g++, cmake,
libeigen3-dev); a peer that is not there is skipped.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from _machine import describe_machine
from _peers import peer_python

from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator

HERE = Path(__file__).resolve().parent
LENGTH = 2 * math.pi
LOADS = np.geomspace(1e-4, 0.1, 16)
SPREAD = (10, 5, 13, 0, 8, 15, 2, 11, 6, 14, 3, 12, 7, 9, 4, 1)
"""Order in which a peer with little time takes the loads."""

SURFACES = {  # points per side, q1, qr
    "1024": (1024, 256, 8.0),
    "2048": (2048, 512, 8.0),
    "2048-nyquist": (2048, 1024, 1.0),
}

CODES = {  # code of scripts/peers/curve.py: name, tolerance, precision
    "roughbench": ("roughbench", 1e-6, "mixed"),
    "aspher": ("ASPHER", 1e-7, "float_then_double"),
    "aspher-double": ("ASPHER", 1e-7, "double"),
    "tamaas": ("Tamaas", 1e-6, "double"),
    "contactmechanics": ("ContactMechanics", 1e-6, "double"),
}


def run(code: str, heights: Path, seconds: float) -> dict[str, Any] | None:
    """Return the answer of one code, or None where it cannot run."""
    python = Path(sys.executable) if code == "roughbench" else peer_python()
    loads = LOADS if code == "roughbench" else LOADS[list(SPREAD)]
    arguments = [LENGTH, CODES[code][1], seconds, *loads]
    done = subprocess.run(
        [python, HERE / "peers" / "curve.py", code, heights, *map(str, arguments)],
        capture_output=True,
        text=True,
        env={k: v for k, v in os.environ.items() if not k.startswith("PYTHON")},
    )
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
        print(f"skipped {CODES[code][0]}: {reason}", file=sys.stderr)
        return None
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def bench(name: str, codes: list[str], rounds: int, seconds: float) -> None:
    """Print the table of one surface."""
    n, q_max, q_rolloff = SURFACES[name]
    spectrum = self_affine(
        hurst=0.7, q_min=1.0, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1
    )
    answers: dict[str, list[dict[str, Any]]] = {code: [] for code in codes}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "heights.npy"
        heights = make_surface(spectrum, n, LENGTH, realization_generator(1, 0))
        rms = float(heights.std())
        np.save(path, heights)
        for _ in range(rounds):
            for code in codes:
                answer = run(code, path, seconds)
                if answer is not None:
                    answers[code].append(answer)
    print(f"\n### N = {n}, q1 = {q_max} q0, qr = {q_rolloff:g} q0, {rounds} rounds\n")
    print(
        "| code | version | precision | tolerance | loads | s, min | s, median | roughbench, "
        "same loads | times slower | pairs/load | worst complementarity | worst penetration "
        "| A at 0.01 | ū/h at 0.01 | GB |"
    )
    print("|" + "-|" * 15)
    own = {state["asked"]: [] for state in answers["roughbench"][0]["states"]}
    for answer in answers["roughbench"]:
        for state in answer["states"]:
            own[state["asked"]].append(state["seconds"])
    for code in codes:
        if answers[code]:
            print(row(code, answers[code], own, rms))


def row(
    code: str, answers: list[dict[str, Any]], own: dict[float, list[float]], rms: float
) -> str:
    """Return the table's row of one code; medians over the rounds."""
    n_loads = min(len(answer["states"]) for answer in answers)
    times = [sum(state["seconds"] for state in a["states"][:n_loads]) for a in answers]
    states = answers[0]["states"][:n_loads]
    base = sum(statistics.median(own[state["asked"]]) for state in states)
    middle = min(states, key=lambda state: abs(state["asked"] - 0.01))
    pairs = statistics.mean(state["pairs"] for state in states)
    title, tolerance, precision = CODES[code]
    return (
        f"| {title} | {answers[0]['version']} | {precision} | {tolerance:.0e} | {n_loads} "
        f"| {min(times):.2f} | {statistics.median(times):.2f} | {base:.2f} "
        f"| {statistics.median(times) / base:.1f} | {f'{pairs:.1f}' if pairs else '–'} "
        f"| {max(state['complementarity'] for state in states):.1e} "
        f"| {max(state['penetration'] for state in states):.1e} "
        f"| {middle['area']:.6f} | {middle['separation'] / rms:.6f} "
        f"| {max(answer['memory'] for answer in answers):.2f} |"
    )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--surface", action="append", choices=list(SURFACES))
    parser.add_argument("--code", action="append", choices=list(CODES)[1:], help="peers")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=60.0, help="per peer and round")
    options = parser.parse_args()
    print(describe_machine("numpy", "numba", "pyfftw"))
    codes = ["roughbench", *(options.code or list(CODES)[1:])]
    for name in options.surface or ["1024"]:
        bench(name, codes, options.rounds, options.seconds)


if __name__ == "__main__":
    main()
