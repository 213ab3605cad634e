"""The page: what the results say as data, set by the templates beside this module."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from importlib import resources
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from roughbench import __version__
from roughbench.figures.axes import axes_of
from roughbench.numbers import number
from roughbench.report.curves import pressure_charts
from roughbench.report.maps import COLOURS, MOST_MAPS, field_maps, n_fields
from roughbench.report.observables import drawn_pressures, observable_charts, pressure_key
from roughbench.report.pictures import MOST_POINTS
from roughbench.report.sources import ReportSource, places
from roughbench.report.styles import PageStyle, experiment_dashes, page_styles
from roughbench.report.surface_tables import synthetic_table
from roughbench.report.surfaces import HEIGHT_COLOURS, surface_sections
from roughbench.report.tables import compared, fit_tables, model_table
from roughbench.report.text import from_notation, from_remedy, plain, without_folders
from roughbench.report.trust import trust_tables
from roughbench.report.verdicts import grouped, measured_value, numbered
from roughbench.report.warnings import ABOUT, Remark, remarks
from roughbench.store import FORMAT_VERSION
from roughbench.verdict import FittedExperiment, Verdict, trust_of

MOST_REMARKS = 12
"""Remarks on one topic that are shown at once; longer lists unfold."""
MOST_CURVES = 8
"""Curves that a chart shows at first with all experiments; of more, the first experiment."""


def render(
    sources: Sequence[ReportSource],
    verdicts: Sequence[Verdict],
    experiments: Sequence[FittedExperiment],
    *,
    reference: str | None = None,
    resamples: int,
    contenders: Sequence[Verdict] = (),
) -> str:
    """Return the page as HTML, the same for the same content.

    Parameters
    ----------
    sources : sequence of ReportSource
    verdicts, contenders : sequence of Verdict
        On the paper's claims, and on every model.
    experiments : sequence of FittedExperiment
        The experiments with their fits.
    reference, resamples : str or None, int
        As they were given for the fits.
    """
    styles = page_styles(sources)
    named = (source.results.name or source.name for source in sources)
    given = f" --reference {reference}" if reference is not None else ""
    files = " ".join(source.name for source in sources)
    return (
        load_templates()
        .get_template("page.html.j2")
        .render(
            names=", ".join(dict.fromkeys(named)),
            command=f"roughbench report {files}{given} --resamples {resamples}",
            version=__version__,
            format_version=FORMAT_VERSION,
            resamples=resamples,
            compared=compared(sources),
            groups=grouped(verdicts),
            contenders=numbered(contenders, len(verdicts) + 1),
            trusts=list(trust_tables(sources, trust_of(experiments))),
            places=places(sources),
            files=[
                _file(f"file-{place}", source, styles) for place, source in enumerate(sources)
            ],
            fits=list(fit_tables(sources, experiments)),
            remarks=_by_topic(remarks(sources)),
            all_have_units=all(source.results.has_units for source in sources),
            any_has_units=any(source.results.has_units for source in sources),
            colours=COLOURS,
            height_colours=HEIGHT_COLOURS,
            most_points=MOST_POINTS,
            most_remarks=MOST_REMARKS,
            asset=_asset,
        )
    )


@functools.cache
def load_templates() -> Environment:
    """Return the templates: they escape all that is not theirs, and miss nothing silently."""
    environment = Environment(
        loader=PackageLoader("roughbench.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "from_notation": from_notation,
        "from_remedy": from_remedy,
        "measured_value": measured_value,
        "number": number,
        "plain": plain,
        "pressure_key": pressure_key,
        "without_folders": without_folders,
    }
    environment.policies["json.dumps_kwargs"] = {
        "allow_nan": False,
        "ensure_ascii": False,
        "separators": (",", ":"),
    }
    return environment


def _asset(*name: str) -> str:
    """Return a file of this package as it is: styles, script, and the library."""
    return resources.files(__package__).joinpath(*name).read_text(encoding="utf-8")


def _file(key: str, source: ReportSource, styles: dict[str, PageStyle]) -> dict[str, Any]:
    """Return legend, charts and maps of a file, and where they come from."""
    dashes = experiment_dashes(source.results)
    many = len(list(source.models())) > MOST_CURVES
    return {
        "key": key,
        "source": source,
        "models": [(label, source.title(label), styles[label]) for label in source.by_label()],
        "experiments": [
            (name, source.experiment(name), dash, place == 0 or not many)
            for place, (name, dash) in enumerate(dashes.items())
        ],
        "surfaces": surface_sections(source),
        "synthetic": synthetic_table(source),
        "pressures": drawn_pressures(source),
        "pressure": axes_of(source.results).pressure,
        "charts": pressure_charts(source, styles),
        "observables": list(observable_charts(source, styles)),
        "maps": field_maps(source),
        "left_out": n_fields(source) - MOST_MAPS,
        "table": model_table(source),
    }


def _by_topic(found: Sequence[Remark]) -> list[tuple[Remark, str, list[Remark]]]:
    """Return the first remark on every topic, what the topic means, and all of them."""
    topics: dict[str, list[Remark]] = {}
    for remark in found:
        topics.setdefault(remark.topic, []).append(remark)
    return [(group[0], ABOUT[topic], group) for topic, group in topics.items()]
