"""A characterization as a text for people: tables with engineering prefixes."""

from __future__ import annotations

import math
from collections.abc import Iterator

from roughbench.scans.characterization import Characterization
from roughbench.scans.roughness import Roughness
from roughbench.scans.self_affine_fit import SelfAffineFit
from roughbench.text import on_one_line
from roughbench.units import in_words, prefix

_WORDS = {
    "Sa": "mean distance from the mean height",
    "Sq": "rms height",
    "Sz": "highest less lowest point",
    "Ssk": "skewness; 0 if Gaussian",
    "Sku": "kurtosis; 3 if Gaussian",
    "Sdq": "rms gradient, by differences of neighbours",
    "Sdr": "area gained over the projection",
}


def as_text(found: Characterization) -> str:
    """Return all of it as lines."""
    blocks = [
        _head(found),
        _prepared(found),
        _roughness(found.raw, found.prepared),
        _moments(found),
        _law(found),
        _warnings(found),
    ]
    return "\n\n".join("\n".join(block) for block in map(list, blocks) if block)


def _head(found: Characterization) -> Iterator[str]:
    scan = found.scan
    rows, columns = scan.shape
    channel = f", channel {on_one_line(scan.channel)}" if scan.channel else ""
    y, x = (in_words(side, "m") for side in scan.size)
    dy, dx = (in_words(step, "m") for step in scan.spacing)
    yield f"{on_one_line(scan.source)}{channel}"
    yield (
        f"{rows} × {columns} points over {y} × {x} (y × x), {dy} × {dx} apart; "
        f"{100.0 * scan.missing:.3g} % missing"
    )


def _prepared(found: Characterization) -> Iterator[str]:
    yield "Prepared:"
    for step in found.steps:
        after = f"Sq {in_words(step.Sq, 'm')}, Sdq {step.Sdq:.3g}"
        yield f"  {step.name + ':':10} {step.text}; {after}"


def _roughness(raw: Roughness, prepared: Roughness) -> Iterator[str]:
    yield f"{'Roughness':10} {'as prepared':>12} {'as read':>12}"
    for name, words in _WORDS.items():
        values = [
            one.peak_to_valley if name == "Sz" else getattr(one, name)
            for one in (prepared, raw)
        ]
        cells = [
            in_words(value, "m")
            if name in ("Sa", "Sq", "Sz")
            else f"{100.0 * value:.3g} %"
            if name == "Sdr"
            else f"{value:.3g}"
            for value in values
        ]
        yield f"  {name:8} {cells[0]:>12} {cells[1]:>12}   {words}"
    ratio = prepared.anisotropy
    yield (
        f"  rms slope {prepared.slopes[0]:.3g} along y, {prepared.slopes[1]:.3g} along x; "
        f"largest over smallest of all directions {ratio:.3g}"
        + (f", the largest at {prepared.direction:.0f}° from x" if ratio > 1.05 else "")
    )


def _moments(found: Characterization) -> Iterator[str]:
    columns = {
        "differences": (
            (found.prepared.m0, found.prepared.m2, found.prepared.m4),
            found.prepared.band,
        ),
        "2D spectrum": (found.surface.profile_moments, found.surface.band),
        "profiles along y": (found.along_y.profile_moments, found.along_y.band),
        "profiles along x": (found.along_x.profile_moments, found.along_x.band),
    }
    yield f"{'Moments of a profile':22}" + "".join(f"{name:>18}" for name in columns)
    rows = (("m0", "m^2", 0), ("m2", "1", 1), ("m4", "1/m^2", 2))
    for name, unit, index in rows:
        values = [moments[index] for moments, _ in columns.values()]
        factor, shown = prefix([value for value in values if value > 0.0] or [0.0], unit)
        label = name if shown == "1" else f"{name} ({shown})"
        yield f"  {label:20}" + "".join(f"{value * factor:>18.4g}" for value in values)
    nayak = [m0 * m4 / m2**2 if m2 else math.inf for (m0, m2, m4), _ in columns.values()]
    yield f"  {'Nayak m0 m4/m2²':20}" + "".join(f"{value:>18.3g}" for value in nayak)
    for words, index in (("longest wave", 0), ("shortest wave", 1)):
        waves = [in_words(2.0 * math.pi / band[index], "m") for _, band in columns.values()]
        yield f"  {words:20}" + "".join(f"{wave:>18}" for wave in waves)


def _law(found: Characterization) -> Iterator[str]:
    how = "with Hann's window" if found.surface.windowed else "without a window: borders meet"
    fit = found.fit
    if fit is None:
        yield f"Self-affine law (2D spectrum {how}): none"
        yield f"  {found.remarks[0]}"
        return
    yield f"Self-affine law (2D spectrum {how}):"
    yield from _parameters(fit)
    for axis, one in zip("yx", found.profiles, strict=True):
        if one is not None:
            yield (
                f"  profiles along {axis}: H {one.hurst:.3f} ± {one.hurst_error:.3f}, with "
                f"{one.level:.3g} times the power of the law"
            )


def _parameters(fit: SelfAffineFit) -> Iterator[str]:
    yield f"  {'H':6} {fit.hurst:.3f} ± {fit.hurst_error:.3f}"
    waves = (
        ("q0", fit.q_min, fit.q_min_error, "longest"),
        ("qr", fit.q_rolloff, fit.q_rolloff_error, "roll-off"),
        ("q1", fit.q_max, fit.q_max_error, "shortest"),
    )
    factor, unit = prefix([q for _, q, _, _ in waves], "1/m")
    for name, q, error, words in waves:
        yield (
            f"  {name:6} {q * factor:.4g} ± {error * factor:.2g} {unit}   ({words} wave "
            f"{in_words(2.0 * math.pi / q, 'm')})"
        )
    yield f"  {'slope':6} {fit.rms_slope:.4g} ± {fit.rms_slope_error:.2g}   (rms, q0 to q1)"


def _warnings(found: Characterization) -> Iterator[str]:
    remarks = [
        text for text in found.warnings if found.fit is not None or text not in found.remarks
    ]
    if remarks:
        yield "Warnings:"
    for text in remarks:
        yield f"  - {text}"
