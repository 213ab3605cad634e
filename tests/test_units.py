"""Numbers with units: what is read, what is refused and how, and what is written."""

from __future__ import annotations

import math
import subprocess
import sys

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roughbench.errors import RoughbenchError, UnitError
from roughbench.units import Dimension, in_words, is_quantity, prefix, to_si

_REGISTRY: pint.UnitRegistry[float] = pint.UnitRegistry()


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("10 um", "length", 1e-5),
        ("0.01 mm", "length", 1e-5),
        ("10um", "length", 1e-5),
        ("10 µm", "length", 1e-5),
        ("10 μm", "length", 1e-5),  # the Greek letter
        ("  20\tnm ", "length", 2e-8),
        ("3 Å", "length", 3e-10),
        (".5e3 nm", "length", 5e-7),
        ("1 inch", "length", 0.0254),
        ("0.1 / um", "wavevector", 1e5),
        ("0.1 1/um", "wavevector", 1e5),
        ("0.1 um^-1", "wavevector", 1e5),
        ("0.1 um**-1", "wavevector", 1e5),
        ("0.1 µm⁻¹", "wavevector", 1e5),
        ("2 rad/um", "wavevector", 2e6),
        ("1 cycle/um", "wavevector", 2e6 * math.pi),
        ("2.5 GPa", "pressure", 2.5e9),
        ("1e3 MPa", "pressure", 1e9),
        ("2 N/mm^2", "pressure", 2e6),
        ("2 N/mm²", "pressure", 2e6),
        ("1 bar", "pressure", 1e5),
        ("1 psi", "pressure", pytest.approx(6894.757293168361, rel=1e-15)),
        ("3 kN m/m^3", "pressure", 3e3),
        ("3 kN·m/m^3", "pressure", 3e3),
        ("0 Pa", "pressure", 0.0),
        ("-2 Pa", "pressure", -2.0),
    ],
)
def test_what_is_read(text: str, dimension: Dimension, value: float) -> None:
    assert to_si(text, dimension, "x") == value
    assert is_quantity(text)


@pytest.mark.parametrize(
    ("text", "dimension", "message"),
    [
        (
            "1 / 10 um",
            "wavevector",
            "x: can be read in two ways, got '1 / 10 um'; write one number: '0.1 / um'",
        ),
        ("1/10um", "wavevector", "write one number: '0.1 / um'"),
        ("1 / 10 um", "length", "write one number: '0.1 um'"),
        ("3 / 4 GPa", "pressure", "write one number: '0.75 GPa'"),
        ("1 / 0 um", "wavevector", "can be read in two ways"),
        ("1/(10 um)", "wavevector", "one number and its unit, such as '0.1 / um', got '1/(10"),
        ("10 um / 3", "length", "one number and its unit, such as '10 um'"),
        ("10 um 3 nm", "length", "one number and its unit"),
        ("2,5 GPa", "pressure", "one number and its unit, such as '2.5 GPa', got '2,5 GPa'"),
        ("1 000 Pa", "pressure", "one number and its unit"),
        ("3 mm2", "length", "one number and its unit"),
        ("GPa", "pressure", "one number and its unit"),
        ("", "length", "one number and its unit"),
        ("nan Pa", "pressure", "one number and its unit"),
        ("10 " + "um " * 100, "length", "one number and its unit"),
        ("2.5", "pressure", "has no unit, got '2.5'; write one behind the number"),
        ("10 um", "pressure", "must be a pressure, such as '2.5 GPa', got '10 um', a length"),
        ("10 um", "wavevector", "such as '0.1 / um', got '10 um', a length"),
        ("1 / um", "length", "got '1 / um', a wavevector"),
        ("2 kg", "length", "must be a length, such as '10 um', got '2 kg'"),
        ("20 degC", "pressure", "must be a pressure"),
        ("20 dB", "pressure", "must be a pressure"),
        ("2.5 gpa", "pressure", "unknown unit 'gpa' in '2.5 gpa' (did you mean 'GPa'?)"),
        ("2.5 frobs", "length", "unknown unit 'frobs' in '2.5 frobs'; write '10 um'"),
        ("1e999 Pa", "pressure", "must be finite"),
        ("1e308 GPa", "pressure", "must be finite"),
        ("1 m^9 m", "length", "must be a length"),
    ],
)
def test_what_is_refused(text: str, dimension: Dimension, message: str) -> None:
    with pytest.raises(UnitError) as error:
        to_si(text, dimension, "x")
    assert message in str(error.value)
    assert str(error.value) == f"x: {error.value.reason}"
    assert isinstance(error.value, RoughbenchError)


def test_an_exponent_without_end_takes_no_time() -> None:
    assert to_si("1e-999999999 m", "length") == 0.0
    assert to_si("1e-300 nm", "length") == 1e-309


@pytest.mark.parametrize("value", [10, 10.0, None, True, "10", "bem", "8.5.1", "2xyz", "1e-3"])
def test_what_is_no_quantity(value: object) -> None:
    assert not is_quantity(value)


@given(
    st.integers(1, 999_999_999),
    st.integers(-12, 6),
    st.sampled_from([("nm", -9), ("um", -6), ("mm", -3), ("m", 0), ("km", 3)]),
)
def test_one_amount_is_one_float(digits: int, exponent: int, unit: tuple[str, int]) -> None:
    name, power = unit
    expected = float(f"{digits}e{exponent}")
    assert to_si(f"{digits}e{exponent - power} {name}", "length") == expected


@given(
    st.lists(st.floats(1e-15, 1e15), min_size=1),
    st.sampled_from(["m", "m^2", "1/m", "1/m^2", "Pa", "Pa/m", "J/m^2", "1", "Pa^2 m^2"]),
)
def test_a_prefix_keeps_the_amount(values: list[float], unit: str) -> None:
    factor, prefixed = prefix(values, unit)
    assert _REGISTRY.Quantity(1.0, unit).to(prefixed).magnitude == pytest.approx(factor)


@pytest.mark.parametrize(
    ("values", "unit", "chosen"),
    [
        ([1e3, 1e5, 1e7], "Pa", (1e-3, "kPa")),
        ([1e5, 1e6, 1e7], "Pa", (1e-6, "MPa")),
        ([1e-8], "m", (1e9, "nm")),
        ([1e-6], "m", (1e6, "µm")),
        ([-1e-8, 0.0, 1e-8], "m", (1e9, "nm")),
        ([math.inf, math.nan, 1e15], "Pa/m", (1e-15, "MPa/nm")),
        ([1e9], "Pa/m", (1e-9, "Pa/nm")),
        ([5e6], "Pa/m", (1e-6, "Pa/µm")),
        ([50.0], "Pa/m", (1.0, "Pa/m")),
        ([2e-3], "J/m^2", (1e3, "mJ/m^2")),
        ([1e7], "1/m", (1e-6, "1/µm")),
        ([2e9], "1/m", (1e-9, "1/nm")),
        ([2e-3], "1/m", (1e3, "1/km")),
        ([1e14], "1/m^2", (1e-12, "1/µm^2")),
        ([3e-34], "m^4", (1e36, "nm^4")),
        ([1e-30], "m", (1e18, "am")),
        ([], "Pa", (1.0, "Pa")),
        ([0.0, math.nan], "m", (1.0, "m")),
        ([2.0], "1", (1.0, "1")),
        ([2.0], "furlong", (1.0, "furlong")),
    ],
)
def test_which_prefix_is_chosen(
    values: list[float], unit: str, chosen: tuple[float, str]
) -> None:
    assert prefix(values, unit) == chosen


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        (1000.0, "Pa", "1 kPa"),
        (999.9999, "Pa", "1 kPa"),
        (3.3333e9, "Pa", "3.33 GPa"),
        (1e15, "Pa/m", "1 MPa/nm"),
        (-2e-9, "m", "-2 nm"),
        (math.inf, "Pa/m", "inf Pa/m"),
        (math.nan, "m", "nan m"),
        (0.5, "1", "0.5"),
    ],
)
def test_words(value: float, unit: str, words: str) -> None:
    assert in_words(value, unit) == words


@given(st.integers(1, 999), st.sampled_from(["Pa", "kPa", "MPa", "GPa"]))
def test_words_lead_back(number: int, unit: str) -> None:
    words = f"{number} {unit}"
    assert in_words(to_si(words, "pressure"), "Pa") == words


def test_pint_is_imported_only_where_a_unit_is_read() -> None:
    code = """import sys
from roughbench import units
units.prefix([1.0], "Pa"), units.is_quantity("bem"), units.is_quantity(1.0)
assert "pint" not in sys.modules
units.to_si("1 Pa", "pressure")
assert "pint" in sys.modules"""
    subprocess.run([sys.executable, "-c", code], check=True)
