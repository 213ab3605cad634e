"""The surfaces of a file: a measured one with its picture, charts and tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roughbench.numbers import number
from roughbench.report.charts import ReportChart
from roughbench.report.pictures import address, coarse, levels, picture
from roughbench.report.sources import ReportSource
from roughbench.report.surface_charts import height_chart, spectrum_chart
from roughbench.report.surface_tables import fit_in_words, parameter_table, step_table
from roughbench.report.tables import ReportTable
from roughbench.report.text import RichText, joined
from roughbench.surface_record import SurfaceRecord
from roughbench.units import in_words, prefix

HEIGHT_COLOURS = (
    (0.0, "#00224e"),
    (0.25, "#3b496c"),
    (0.5, "#7b7b78"),
    (0.75, "#bcad6c"),
    (1.0, "#fee838"),
)
"""From the lowest to the highest point: told apart with any colour vision, and in grey."""


@dataclass(frozen=True, slots=True)
class SurfaceSection:
    """What the page shows of one measured surface.

    Attributes
    ----------
    key : str
        Of its elements.
    title : RichText
    image, label, shape : str
        The map as an address, what stands in its place, and its shape, width / height.
    scale : tuple of str
        Lowest height, the mean and the highest.
    caption : str
        How large it is.
    charts : list of ReportChart
        Spectrum and distribution of heights.
    fit : RichText
        The self-affine law in words.
    parameters, steps : ReportTable
        The surface in numbers, and how it was prepared.
    warnings : tuple of str
    """

    key: str
    title: RichText
    image: str
    label: str
    shape: str
    scale: tuple[str, ...]
    caption: str
    charts: list[ReportChart]
    fit: RichText
    parameters: ReportTable
    steps: ReportTable
    warnings: tuple[str, ...]


def surface_sections(source: ReportSource) -> list[SurfaceSection]:
    """Return the measured surfaces of a file, in the order of its experiments."""
    return [
        _section(source, name, source.results.surfaces[name], place)
        for place, name in enumerate(source.results)
        if name in source.results.surfaces
    ]


def _section(
    source: ReportSource, experiment: str, record: SurfaceRecord, place: int
) -> SurfaceSection:
    height, width = (in_words(length, "m") for length in record.size)
    named = record.source or source.name
    low, high = float(np.nanmin(record.heights)), float(np.nanmax(record.heights))
    factor, unit = prefix([low, high], "m")
    shown = (
        (record.heights - low) / (high - low) if high > low else np.zeros_like(record.heights)
    )
    pixels = levels(coarse(np.asarray(shown, float)))
    title = joined([named, *[source.experiment(experiment)] * source.has_sweep])
    return SurfaceSection(
        f"surface-{place}",
        title,
        address(picture(pixels, HEIGHT_COLOURS)),
        f"Map of the heights of {named}, {width} by {height}",
        f"{record.size[1] / record.size[0]:.6g}",
        tuple(f"{number(value * factor)} {unit}" for value in (low, high)),
        f"{width} × {height}",
        [spectrum_chart(record), height_chart(record)],
        fit_in_words(record.fit),
        parameter_table(record),
        step_table(record),
        tuple(record.warnings),
    )
