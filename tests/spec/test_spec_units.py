"""Specs with units: what they mean, what they keep, and every mixture refused."""

from __future__ import annotations

import math

import pytest

from roughbench.errors import SpecError
from roughbench.models.winkler import Winkler
from roughbench.spec import FileSurface, SelfAffineSurface, Spec, load_spec, parse_spec

PLATE = """\
name: plate
surface:
  H: 0.8
  longest: 10 um
  rolloff: 2 um
  shortest: 100 nm
  rms_height: 12 nm
modulus: {E: 2.5 GPa, nu: 0.5}
pressures: {min: 1 kPa, max: 10 MPa, points: 5}
models: [{kind: persson}]
"""
BARE = """\
surface: {H: 0.8, q0: 1, qr: 8, q1: 100, slope: 0.1}
pressures: [0.1]
models: [{kind: persson}]
"""


def faults_of(text: str, *overrides: str) -> list[str]:
    with pytest.raises(SpecError) as caught:
        load_spec(text, overrides)
    return [str(fault).removeprefix("spec:") for fault in caught.value.faults]


def surface_of(spec: Spec) -> SelfAffineSurface:
    assert isinstance(spec.surface, SelfAffineSurface)
    return spec.surface


def test_the_values_inside_are_si_and_pressures_over_the_modulus() -> None:
    spec = load_spec(PLATE)
    surface = surface_of(spec)
    assert spec.modulus == pytest.approx(2.5e9 / 0.75, rel=1e-15)
    assert surface.q_min == 2 * math.pi / 10e-6
    assert surface.q_rolloff == 2 * math.pi / 2e-6
    assert surface.q_max == 2 * math.pi / 100e-9
    assert surface.rms_height == 12e-9
    assert surface.length == pytest.approx(10e-6, rel=1e-15)
    assert spec.pressures == pytest.approx([3e-7, 3e-6, 3e-5, 3e-4, 3e-3], rel=1e-14)


def test_a_bare_spec_has_no_modulus_and_hashes_as_before() -> None:
    spec = load_spec(BARE)
    assert spec.modulus is None
    assert spec.pressures == (0.1,)
    assert "modulus" not in spec.resolved()["main"]
    assert spec.sha256 == "42ce179577703537745b43c009077909fab4ae6808906a94a308aca89885f9ce"


@pytest.mark.parametrize(
    ("modulus", "value"),
    [
        ("{E: 2.5 GPa, nu: 0.5}", 2.5e9 / 0.75),
        ("{E*: 3.33 GPa}", 3.33e9),
        ("[{E: 70 GPa, nu: 0.3}, {E: 2.5 GPa, nu: 0.5}]", 1 / (0.91 / 70e9 + 0.75 / 2.5e9)),
    ],
)
def test_the_contact_modulus(modulus: str, value: float) -> None:
    spec = load_spec(PLATE.replace("{E: 2.5 GPa, nu: 0.5}", modulus))
    assert spec.modulus == pytest.approx(value, rel=1e-15)


def test_wavevectors_and_other_units_mean_the_same() -> None:
    q0, qr, q1 = (2 * math.pi / length for length in (10, 2, 0.1))
    text = (
        PLATE.replace("longest: 10 um", f"q0: {q0!r} / um")
        .replace("rolloff: 2 um", f"qr: {qr!r} 1/um")
        .replace("shortest: 100 nm", f"q1: {q1 * 1e3!r} / mm")
        .replace("rms_height: 12 nm", "rms_height: 0.012 um")
        .replace("{min: 1 kPa, max: 10 MPa, points: 5}", "[1000 Pa, 10 kPa, 1 bar, 1 MPa]")
        .replace("E: 2.5 GPa", "E: 2500 MPa")
    )
    one, other = load_spec(PLATE), load_spec(text)
    for name in ("q_min", "q_rolloff", "q_max", "rms_height", "length"):
        expected = getattr(surface_of(one), name)
        assert getattr(surface_of(other), name) == pytest.approx(expected, rel=1e-14)
    assert other.modulus == one.modulus
    assert other.pressures == pytest.approx(one.pressures[:4], rel=1e-14)


def test_what_was_written_is_kept() -> None:
    spec = load_spec(PLATE)
    assert spec.text == PLATE
    tree = spec.as_given()
    assert tree["surface"]["longest"] == "10 um"
    assert tree["pressures"] == {"min": "1 kPa", "max": "10 MPa", "points": 5}
    for again in (load_spec(tree), parse_spec(spec.text), load_spec(load_spec(tree).text)):
        assert again == spec
        assert again.sha256 == spec.sha256
    other = load_spec(spec, ["surface.rolloff=3 um", "pressures=[2 kPa]"])
    assert surface_of(other).q_rolloff == 2 * math.pi / 3e-6
    assert other.modulus is not None
    assert other.pressures == (2e3 / other.modulus,)
    assert "rolloff: 3 um" in other.text
    assert load_spec(other.text) == other


def test_the_hash_knows_the_modulus() -> None:
    softer = PLATE.replace("2.5 GPa", "0.25 GPa").replace("1 kPa, max: 10", "0.1 kPa, max: 1")
    one, other = load_spec(PLATE), load_spec(softer)
    assert other.pressures == pytest.approx(one.pressures, rel=1e-14)
    assert other.sha256 != one.sha256


def test_a_sweep_is_named_as_it_is_written() -> None:
    sweep = (
        "sweep: {surface.rolloff: [2 um, 3 µm], modulus.E: [2 GPa, 3 N/mm^2], "
        "surface.shortest: [100 nm]}\n"
    )
    found = dict(load_spec(PLATE + sweep).experiments())
    assert list(found) == [
        "surface.rolloff=2um,modulus.E=2GPa,surface.shortest=100nm",
        "surface.rolloff=2um,modulus.E=3N_per_mm_2,surface.shortest=100nm",
        "surface.rolloff=3um,modulus.E=2GPa,surface.shortest=100nm",
        "surface.rolloff=3um,modulus.E=3N_per_mm_2,surface.shortest=100nm",
    ]
    last = [*found.values()][-1]
    assert last.modulus == 4e6
    assert surface_of(last).q_rolloff == 2 * math.pi / 3e-6
    vectors = PLATE.replace("rolloff: 2 um", "qr: 1 / um")
    swept = load_spec(vectors + "sweep: {surface.qr: [1 / µm, 2e6 1/m]}\n")
    assert [name for name, _ in swept.experiments()] == [
        "surface.qr=1um-1",
        "surface.qr=2e6m-1",
    ]


def test_fields_are_kept_at_pressures_with_units() -> None:
    spec = load_spec(PLATE + "save_fields: {pressures: [10 MPa, 1e3 Pa]}\n")
    assert spec.kept_pressures == (spec.pressures[0], spec.pressures[-1])
    fault = "11:27: error: save_fields.pressures[0]: 2 kPa is none of the spec's pressures; "
    assert faults_of(PLATE + "save_fields: {pressures: [2 kPa]}\n") == [
        f"{fault}add it to them, or write the nearest, 1 kPa"
    ]


def test_options_of_models_have_units_too() -> None:
    spec = load_spec(PLATE.replace("{kind: persson}", "{kind: winkler, modulus: 2 / um}"))
    assert isinstance(spec.models[0], Winkler)
    assert spec.models[0].modulus == 2e6
    assert faults_of(PLATE.replace("{kind: persson}", "{kind: winkler, modulus: 2}")) == [
        (
            "10:35: error: models[0].modulus: has no unit, but modulus.E has one, got 2; "
            "write it as in '0.1 / um'"
        )
    ]


def test_heights_in_a_file_have_a_unit_beside_the_length() -> None:
    text = (
        "surface: {kind: file, path: h.npy, length: 10 um, unit: nm}\n"
        "modulus: {E*: 1 GPa}\npressures: [1 kPa]\nmodels: [{kind: bem}]\n"
    )
    surface = parse_spec(text).surface
    assert isinstance(surface, FileSurface)
    assert (surface.length, surface.unit) == (1e-5, 1e-9)
    with pytest.raises(SpecError, match=r"surface.unit: is missing: that of the heights"):
        parse_spec(text.replace(", unit: nm", ""))
    for wrong in ("kPa", "3", "3 nm", "nmm"):
        with pytest.raises(SpecError, match=r"unit: must be a unit of length, such as nm, got"):
            parse_spec(text.replace("unit: nm", f"unit: {wrong}"))
    with pytest.raises(SpecError, match="length: has no unit"):
        parse_spec(text.replace("length: 10 um", "length: 10"))


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        (
            "longest: 10 um",
            "q0: 1.0",
            (
                "4:7: error: surface.q0: has no unit, but modulus.E has one, got 1.0; "
                "write it as "
                "in '0.1 / um'"
            ),
        ),
        (
            "longest: 10 um",
            "q0: 1 / 10 um",
            (
                "4:7: error: surface.q0: can be read in two ways, got '1 / 10 um'; write one "
                "number: '0.1 / um'"
            ),
        ),
        (
            "longest: 10 um",
            "q0: 10 um",
            (
                "4:7: error: surface.q0: must be a wavevector, such as '0.1 / um', got "
                "'10 um', a "
                "length"
            ),
        ),
        (
            "longest: 10 um",
            "longest: 0.1 / um",
            (
                "4:12: error: surface.longest: must be a length, such as '10 um', got "
                "'0.1 / um', "
                "a wavevector"
            ),
        ),
        (
            "longest: 10 um",
            "longest: -10 um",
            "4:12: error: surface.longest: must be greater than 0, got '-10 um'",
        ),
        (
            "longest: 10 um",
            "longest: true",
            "4:12: error: surface.longest: must be a length, such as '10 um', got true",
        ),
        (
            "longest: 10 um",
            "longst: 10 um",
            "4:3: error: surface.longst: unknown key (did you mean 'longest'?)",
        ),
        (
            "longest: 10 um",
            "q0: 1 / um\n  longest: 10 um",
            "5:3: error: surface.longest: says the same as q0 = 2π/longest; remove one of them",
        ),
        (
            "rolloff: 2 um",
            "rolloff: 20 um",
            "5:12: error: surface.rolloff: must be at most longest = 10 um, got 20 um",
        ),
        (
            "shortest: 100 nm",
            "shortest: 2 um",
            "6:13: error: surface.shortest: must be less than rolloff = 2 um, got 2 um",
        ),
        (
            "shortest: 100 nm",
            "shortest: some nm",
            (
                "6:13: error: surface.shortest: must be one number and its unit, such "
                "as '10 um', "
                "got 'some nm'"
            ),
        ),
        (
            "shortest: 100 nm",
            "q1: 3 / um",
            "6:7: error: surface.q1: must be greater than qr = 3.14159 / µm, got 3 / µm",
        ),
        (
            "rms_height: 12 nm",
            "rms_height: 12",
            (
                "7:15: error: surface.rms_height: has no unit, but modulus.E has one, got 12; "
                "write it as in '10 um'"
            ),
        ),
        (
            "rms_height: 12 nm",
            "rms_height: -12 nm",
            "7:15: error: surface.rms_height: must be greater than 0, got '-12 nm'",
        ),
        (
            "rms_height: 12 nm",
            "rms_height: 12 nm\n  length: 9 um",
            (
                "8:11: error: surface.length: must be at least 2π/q0 = 10 µm, the "
                "longest wave, got "
                "9 µm"
            ),
        ),
        (
            "max: 10 MPa",
            "max: 10",
            (
                "9:30: error: pressures.max: has no unit, but modulus.E has one, got "
                "10; write it "
                "as in '2.5 GPa'"
            ),
        ),
        (
            "max: 10 MPa",
            "max: 500 Pa",
            "9:30: error: pressures.max: must be greater than min = 1 kPa, got 500 Pa",
        ),
        (
            "max: 10 MPa",
            "max: high",
            (
                "9:30: error: pressures.max: must be one number and its unit, such as "
                "'2.5 GPa', "
                "got 'high'"
            ),
        ),
        (
            "{min: 1 kPa, max: 10 MPa, points: 5}",
            "[1 kPa, 1000 Pa]",
            "9:20: error: pressures[1]: the pressure 1 kPa stands at [0] already",
        ),
        (
            "modulus: {E: 2.5 GPa, nu: 0.5}\n",
            "",
            (
                "1:1: error: modulus: is missing, which a spec with units needs, such as "
                "{E: 2.5 GPa, nu: 0.5}"
            ),
        ),
        (
            "{E: 2.5 GPa, nu: 0.5}",
            "3 GPa",
            (
                "8:10: error: modulus: must be {E: 2.5 GPa, nu: 0.5}, a list of two bodies, or "
                "{E*: 3.33 GPa}, got '3 GPa'"
            ),
        ),
        (
            "{E: 2.5 GPa, nu: 0.5}",
            "{E: 2.5e9, nu: 0.5}",
            (
                "8:14: error: modulus.E: has no unit, but surface.longest has one, got "
                "2500000000.0; write it as in '2.5 GPa'"
            ),
        ),
        (
            "{E: 2.5 GPa, nu: 0.5}",
            "{E: 2.5 GPa}",
            "8:1: error: modulus.nu: is missing (Poisson's ratio, 0.5 where incompressible)",
        ),
        (
            "{E: 2.5 GPa, nu: 0.5}",
            "[{E: 2.5 GPa, nu: 0.5}, {E: 70 GPa, nu: 2}]",
            "8:50: error: modulus[1].nu: must be at most 0.5, got 2",
        ),
        (
            "{E: 2.5 GPa, nu: 0.5}",
            "[{E: 2.5 GPa, nu: 0.5}]",
            (
                "8:10: error: modulus: has one body in its list; write it without brackets, or "
                "add the other"
            ),
        ),
        (
            "points: 5}\n",
            "points: 5}\nsweep: {surface.rolloff: [2 um, 4]}\n",
            (
                "10:33: error: sweep.surface.rolloff[1]: has no unit, but modulus.E has "
                "one, got 4; write "
                "it as in '10 um'"
            ),
        ),
    ],
)
def test_faults(old: str, new: str, fault: str) -> None:
    assert old in PLATE
    assert faults_of(PLATE.replace(old, new)) == [fault]


def test_the_few_values_with_a_unit_are_the_fault_of_a_bare_spec() -> None:
    remedy = "give all lengths, wavevectors and pressures a unit, or none"
    assert faults_of(BARE.replace("slope: 0.1", "slope: 0.1, length: 10 um")) == [
        f"1:62: error: surface.length: has a unit, '10 um', but surface.q0 has none; {remedy}"
    ]
    mixed = BARE.replace("[0.1]", "{min: 1 kPa, max: 0.1, points: 3}")
    assert faults_of(mixed) == [  # and not that 0.1 is less than 1000
        f"2:18: error: pressures.min: has a unit, '1 kPa', but surface.q0 has none; {remedy}"
    ]
    assert faults_of(BARE, "surface.length=10 um") == [
        (
            "--set surface.length=10 um: error: surface.length: has a unit, '10 um', "
            "but surface.q0 "
            f"has none; {remedy}"
        )
    ]


def test_a_modulus_alone_asks_for_units_everywhere() -> None:
    faults = faults_of(BARE + "modulus: {E*: 1 GPa}\n")
    assert [fault.split(" ")[2] for fault in faults] == [
        "surface.q0:",
        "surface.qr:",
        "surface.q1:",
        "pressures[0]:",
    ]
    assert all("has no unit, but modulus.E* has one" in fault for fault in faults)


def test_other_faults_are_told_beside_those_of_units() -> None:
    faults = faults_of(PLATE.replace("H: 0.8", "H: 2").replace("rms_height: 12 nm", "slope: x"))
    assert [fault.split(" ")[2] for fault in faults] == ["surface.H:", "surface.slope:"]
    mixed = PLATE.replace("H: 0.8", "H: 2").replace("12 nm", "12")
    assert [fault.split(" ")[2] for fault in faults_of(mixed)] == [
        "surface.H:",
        "surface.rms_height:",
    ]


def test_an_unknown_unit_suggests_one() -> None:
    [fault] = faults_of(PLATE.replace("2.5 GPa", "2.5 gpa"))
    assert fault.endswith(
        "modulus.E: has an unknown unit 'gpa' in '2.5 gpa' (did you mean 'GPa'?)"
    )
