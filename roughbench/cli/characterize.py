"""``roughbench characterize``: what a measured surface is like."""

from __future__ import annotations

from pathlib import Path

import click

from roughbench.cli.options import debug_option, example


def _share(_ctx: click.Context, _parameter: click.Parameter, value: str | None) -> float | None:
    if value is None:
        return None
    text = value.strip()
    try:
        share = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        share = -1.0
    if not 0.0 <= share < 1.0:
        raise click.BadParameter(f"must be a share such as 5% or 0.05, got {value!r}")
    return share


@click.command(
    "characterize",
    epilog=example(
        "roughbench characterize plate.al3d -o plate.yaml",
        'roughbench characterize heights.npy --size "10 um, 5 um" --unit nm --json',
    ),
)
@click.argument("file", metavar="FILE")
@click.option("--json", "as_json", is_flag=True, help="All numbers, SI, as strict JSON.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="SPEC.yaml",
    help="Write a spec that computes with the scan as it was prepared.",
)
@click.option(
    "--figure",
    "picture",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="PICTURE.png",
    help="Draw map, spectrum and heights' distribution, as .png, .pdf or .svg.",
)
@click.option("--size", help='Of the scan along x and y, as "10 um" or "10 um, 5 um".')
@click.option("--unit", help="Of the heights, as nm.")
@click.option("--channel", help="Of a file with several; default: the first heights.")
@click.option(
    "--detrend",
    type=click.Choice(["none", "mean", "plane", "quadratic"]),
    default="plane",
    show_default=True,
    help="What is subtracted.",
)
@click.option(
    "--fill",
    callback=_share,
    metavar="SHARE",
    help="Largest share of missing points that is filled, as 5%; default: half, and a warning.",
)
@click.option(
    "--edges",
    type=click.Choice(["periodic", "mirror", "taper", "crop"]),
    help="How the scan becomes periodic for contact; spectra are taken before that.",
)
@click.option(
    "--outliers",
    type=click.FloatRange(min=0.0, min_open=True),
    help="Take points out that are so many robust deviations off their neighbours.",
)
@click.option("--resample", type=click.IntRange(min=4), help="Points along the longer side.")
@debug_option
def command(
    file: str,
    as_json: bool,  # noqa: FBT001
    output: Path | None,
    picture: Path | None,
    size: str | None,
    unit: str | None,
    channel: str | None,
    detrend: str,
    fill: float | None,
    edges: str | None,
    outliers: float | None,
    resample: int | None,
) -> None:
    """Describe the measured surface in FILE.

    Heights, slopes and curvatures (ISO 25178-2, Nayak), spectra of the surface and of its
    profiles along both axes, a self-affine law with errors or why there is none, and what to
    doubt. All numbers are of the heights as prepared; what was done to them is listed.
    """
    import json

    from roughbench.cli.characterize_text import as_text
    from roughbench.outputs import Kind, check_output, write_output
    from roughbench.scans.characterization import characterize
    from roughbench.scans.spec_text import MARK, spec_text
    from roughbench.system import split_dataset

    spec = Kind("spec", lambda head, _: head.startswith(MARK.encode()))
    inputs = [split_dataset(file)[0] or file]
    if output is not None:
        check_output(output, spec, inputs)
    if picture is not None:
        from roughbench.figures.characterization import check_picture

        check_picture(picture, inputs)
    found = characterize(
        file,
        size=size,
        unit=unit,
        channel=channel,
        detrend=detrend,  # type: ignore[arg-type]  # click's choice
        fill=fill,
        edges=edges,  # type: ignore[arg-type]
        outliers=outliers,
        resample=resample,
    )
    if as_json:
        click.echo(json.dumps(found.to_dict(), indent=2, ensure_ascii=False, allow_nan=False))
    else:
        click.echo(as_text(found))
    if output is not None:
        text = spec_text(found, output.parent, size=size, unit=unit, channel=channel)
        click.echo(write_output(text.encode(), output, spec, inputs), err=as_json)
    if picture is not None:
        from roughbench.figures.characterization import draw_picture

        click.echo(draw_picture(found, picture, inputs), err=as_json)
