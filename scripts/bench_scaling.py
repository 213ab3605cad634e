"""Measure how the exact solver scales with the grid, the threads and the load.

    python scripts/bench_scaling.py [--largest 2048] [--low 4096] [--rounds 2] [--plot FILE.png]

Three tables on self-affine surfaces, H = 0.7, rms slope 0.1, qr = q0:

* a curve of 16 loads p/E* = 1e-4 … 0.1, stiffness included, over the grid, with 4 and
  with 2 points on the shortest wave, and with 1, 2, … threads. Its floor is the time of
  as many bare transform pairs, float32, at as many threads, measured in the same round;
* the share of a curve's time that is spent in transforms;
* loads from 1e-7 to 1e-5 on 4096² points, with the direct and the split sum over the loaded
  points and without.
"""

from __future__ import annotations

import argparse
import math
import os
import statistics
import time
from pathlib import Path

import numpy as np
from _machine import describe_machine
from numpy.typing import NDArray

from roughbench.models.base import CompleteCurve
from roughbench.models.halfspace import evaluation, workspace
from roughbench.models.halfspace.contact import solve_curve
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.states import solve_states
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator
from roughbench.transform import RealTransform

LENGTH = 2 * math.pi
LOADS = np.geomspace(1e-4, 0.1, 16)
LOW_LOADS = np.geomspace(1e-7, 1e-5, 5)


def rough(n: int, points_per_wave: int) -> NDArray[np.float64]:
    """Return heights of n × n points."""
    spectrum = self_affine(
        hurst=0.7, q_min=1.0, q_rolloff=1.0, q_max=n // points_per_wave, rms_slope=0.1
    )
    return make_surface(spectrum, n, LENGTH, realization_generator(1, 0))


def pair_seconds(n: int, threads: int, repeats: int = 7) -> float:
    """Return the time of a bare transform pair, float32, in place."""
    transform = RealTransform((n, n), np.float32, threads)
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        transform.forward()
        transform.backward()
        times.append(time.perf_counter() - begin)
        transform.spectral /= n * n
    return statistics.median(times)


class TransformClock:
    """Adds up the time spent in transforms while it is open."""

    def __enter__(self) -> TransformClock:
        self.seconds = 0.0
        self._plain = RealTransform.forward, RealTransform.backward

        def timed(plain):  # type: ignore[no-untyped-def]
            def call(transform: RealTransform) -> None:
                begin = time.perf_counter()
                plain(transform)
                self.seconds += time.perf_counter() - begin

            return call

        RealTransform.forward, RealTransform.backward = map(timed, self._plain)  # type: ignore[method-assign]
        return self

    def __exit__(self, *_: object) -> None:
        RealTransform.forward, RealTransform.backward = self._plain  # type: ignore[method-assign]


def curves(sizes: list[int], threads: list[int], rounds: int) -> list[dict[str, float]]:
    """Time curves; print a row each."""
    print(
        "\n| N | points per wave | threads | s per load, median (min) | pairs per load "
        "| floor: bare pairs, s | ratio | in transforms | worst complementarity |"
    )
    print("|" + "-|" * 9)
    rows = []
    for points_per_wave in (4, 2):
        for n in sizes:
            heights = rough(n, points_per_wave)
            for count in threads:
                HalfSpaceOperator((n, n), np.float32, ThreadTeam(count))  # plan beforehand
                times, floors, shares = [], [], []
                for _ in range(rounds):
                    pair = pair_seconds(n, count)
                    with TransformClock() as clock:
                        begin = time.perf_counter()
                        curve = solve_curve(heights, LOADS, length=LENGTH, threads=count)
                        times.append((time.perf_counter() - begin) / LOADS.size)
                    assert curve.diagnostics is not None
                    pairs = float(curve.diagnostics["transform_pairs"].mean())
                    floors.append(pairs * pair)
                    shares.append(clock.seconds / (times[-1] * LOADS.size))
                seconds, floor = statistics.median(times), statistics.median(floors)
                print(
                    f"| {n} | {points_per_wave} | {count} | {seconds:.3f} ({min(times):.3f}) "
                    f"| {pairs:.1f} | {floor:.3f} | {seconds / floor:.2f} "
                    f"| {statistics.median(shares):.0%} "
                    f"| {curve.diagnostics['complementarity'].max():.1e} |",
                    flush=True,
                )
                rows.append(
                    {
                        "n": n,
                        "per_wave": points_per_wave,
                        "threads": count,
                        "seconds": seconds,
                        "floor": floor,
                    }
                )
    return rows


def low_loads(n: int, threads: int, rounds: int) -> None:
    """Time single low loads with and without sums over the points; print a row each."""
    print(
        f"\nN = {n}, {threads} threads, loads one after the other, stiffness included; "
        "s per load, median\n"
    )
    print(
        "| points per wave | p/E* | A/A0 | sums | transforms | ratio "
        "| worst complementarity | largest difference of ū/h, A/A0 |"
    )
    print("|" + "-|" * 8)
    usual, usual_split = evaluation.DIRECT_SUM_MAX_FRACTION, workspace.SPLIT_MAX_FRACTION
    for points_per_wave in (4, 2):
        heights = rough(n, points_per_wave)
        times: dict[float, list[list[float]]] = {usual: [], 0.0: []}
        answers = {}
        for _ in range(rounds):
            for share, runs in times.items():
                evaluation.DIRECT_SUM_MAX_FRACTION = share
                workspace.SPLIT_MAX_FRACTION = usual_split if share else 0.0
                ends: list[float] = [time.perf_counter()]
                loads = [LOW_LOADS[0] / 2, *LOW_LOADS]  # the first has the start-up in it
                states = []
                for state in solve_states(heights, loads, length=LENGTH, threads=threads):
                    ends.append(time.perf_counter())
                    states.append(state)
                answers[share] = CompleteCurve.from_states(states, np.array(loads))
                runs.append(list(np.diff(ends)[1:]))
        evaluation.DIRECT_SUM_MAX_FRACTION = usual
        workspace.SPLIT_MAX_FRACTION = usual_split
        direct, grid = (np.median(runs, axis=0) for runs in times.values())
        one, other = answers.values()
        assert one.diagnostics is not None
        for i, load in enumerate(LOW_LOADS):
            gap = abs(one.separation[i + 1] / other.separation[i + 1] - 1)
            area = abs(one.area_raw[i + 1] - other.area_raw[i + 1])
            print(
                f"| {points_per_wave} | {load:.1e} | {one.area_raw[i + 1]:.2e} "
                f"| {direct[i]:.4f} | {grid[i]:.3f} | {grid[i] / direct[i]:.1f} "
                f"| {one.diagnostics['complementarity'][i + 1]:.1e} | {gap:.0e}, {area:.0e} |",
                flush=True,
            )


def plot(rows: list[dict[str, float]], path: Path) -> None:
    """Draw seconds per load over the grid, with the floor."""
    import matplotlib as mpl

    mpl.use("agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(4.2, 3.2), layout="constrained")
    colours = {1: "tab:blue", 2: "tab:orange", 4: "tab:green", 8: "tab:red"}
    for count in sorted({row["threads"] for row in rows}):
        for per_wave, marker in ((4, "o"), (2, "s")):
            chosen = [
                row for row in rows if row["threads"] == count and row["per_wave"] == per_wave
            ]
            n = [row["n"] for row in chosen]
            colour = colours.get(int(count), "black")
            label = f"{count:.0f} thread{'s' * (count > 1)}, {per_wave} points per wave"
            axes.loglog(
                n, [r["seconds"] for r in chosen], marker, ls="-", color=colour, label=label
            )
            axes.loglog(n, [r["floor"] for r in chosen], marker, ls=":", mfc="w", color=colour)
    axes.loglog([], [], ":", color="0.3", label="bare transform pairs")
    sizes = sorted({row["n"] for row in rows})
    axes.set_xticks(sizes, [f"{n:.0f}" for n in sizes])
    axes.minorticks_off()
    axes.set_xlabel("grid points per side")
    axes.set_ylabel("seconds per load")
    axes.legend(fontsize="x-small")
    figure.savefig(path, dpi=200)
    print(f"\n{path}")


def main() -> None:
    """Print the tables, draw the plot."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=2048)
    parser.add_argument("--low", type=int, default=4096, help="grid of the low loads")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--plot", type=Path)
    options = parser.parse_args()
    print(describe_machine("numpy", "numba", "pyfftw"))
    cores = len(os.sched_getaffinity(0))
    threads = [2**k for k in range(cores.bit_length()) if 2**k <= cores]
    sizes = [n for n in (256, 512, 1024, 2048, 4096, 8192) if n <= options.largest]
    rows = curves(sizes, threads, options.rounds)
    low_loads(options.low, threads[-1], options.rounds)
    if options.plot:
        plot(rows, options.plot)


if __name__ == "__main__":
    main()
