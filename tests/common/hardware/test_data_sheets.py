"""What data sheets state becomes the rate or the probability that its source says."""

import mpmath
import pytest

from tracerisk.common.hardware.formats import read_description, write_description
from tracerisk.common.hardware.model import Basis
from tracerisk.errors import InputError
from tracerisk.pipeline.failure_data.field_failures import read_failures, updated_yaml, updates
from tracerisk.pipeline.failure_data.supplier_table import read_figures, with_figures
from tracerisk.report.hardware_table import figure_text


def only_figure(tmp_path, text, name="h.yaml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    (component,) = read_description(path).components
    (figure,) = component.figures
    return figure


def of_yaml(tmp_path, figure):
    return only_figure(tmp_path, f"components:\n  a: {{twin: {{gripper: true}}, {figure}}}\n")


def of_sysml(tmp_path, figure):
    return only_figure(
        tmp_path,
        "package C { private import TraceriskHardware::*; private import SI::*;\n"
        f"part s {{ part a {{ attribute life : ISQ::DurationValue = 50000 [h]; @FailureData {{ "
        f"{figure} }} @TwinBinding {{ gripper = true; }} }} }} }}",
        "h.sysml",
    )


YEAR = mpmath.mpf(365) * 24
RATES = [
    ("mtbf: {value: 886000, unit: hour}", "mtbf = 886000 [h];", 1 / mpmath.mpf(886000)),
    ("mttf: {value: 40, unit: year}", "mttf = 14600 [SI::d];", 1 / (40 * YEAR)),
    (
        "mttfd: {value: 150, unit: year, dangerous: 0.25}",
        "mttfd = 1314000 [h]; dangerous = 0.25;",
        4 / (150 * YEAR),
    ),
    (
        "b10d: {value: 2e7, cycles: {value: 219000, per: year}}",
        "b10d = 20000000; cycles = 25 [h^-1];",
        mpmath.mpf(25) / 10 / 20000000,
    ),
    (
        "b10: {value: 1e6, cycles: {value: 2, per: minute}}",
        "b10 = 1000000; cycles = 2 [min^-1];",
        mpmath.mpf(120) / 10 / 10**6,
    ),
]


@pytest.mark.parametrize(("yaml", "sysml", "rate"), RATES)
def test_a_mean_time_or_cycles_per_time_is_a_rate(tmp_path, yaml, sysml, rate):
    for figure in (of_yaml(tmp_path, yaml), of_sysml(tmp_path, sysml)):
        assert (figure.kind, figure.per, figure.value_is) == ("failure_rate", Basis.HOUR, "mean")
        assert figure.value == pytest.approx(float(rate), rel=1e-15)


@pytest.mark.parametrize(
    ("yaml", "sysml", "demand"),
    [
        ("b10: {value: 4e5, of: release}", "b10 = 400000; demand = Use::release;", "release"),
        ("b10d: {value: 4e5}", "b10d = 400000;", None),
    ],
)
def test_cycles_alone_count_demands(tmp_path, yaml, sysml, demand):
    for figure in (of_yaml(tmp_path, yaml), of_sysml(tmp_path, sysml)):
        assert (figure.kind, figure.per, figure.demand) == ("probability", Basis.DEMAND, demand)
        assert figure.value == pytest.approx(2.5e-7, rel=1e-15)


@pytest.mark.parametrize(
    ("rated", "working", "energy"), [(40, 55, 0.7), (25, 25, 1), (60, 20, 0.3)]
)
def test_a_temperature_multiplies_by_arrhenius(tmp_path, rated, working, energy):
    with mpmath.workdps(30):
        # k of the exact SI constants: 1.380649e-23 J/K over 1.602176634e-19 C.
        boltzmann = mpmath.mpf("1.380649e-23") / mpmath.mpf("1.602176634e-19")
        kelvin = [mpmath.mpf("273.15") + value for value in (rated, working)]
        factor = mpmath.exp(energy / boltzmann * (1 / kelvin[0] - 1 / kelvin[1]))
    yaml = f"temperature: {{rated: {rated}, working: {working}, activation_energy: {energy}}}"
    at = f"rated = {rated}; working = {working}; activationEnergy = {energy};"
    for figure in (
        of_yaml(tmp_path, f"failure_rate: {{value: 500, unit: FIT, {yaml}}}"),
        of_sysml(tmp_path, f"rate = 500 [FIT]; temperature {{ {at} }}"),
    ):
        assert figure.value == pytest.approx(float(5e-7 * factor), rel=1e-9)
    mean = of_yaml(tmp_path, f"mtbf: {{value: 2e6, unit: hour, {yaml}}}")
    assert mean.value == pytest.approx(float(5e-7 * factor), rel=1e-9)


def test_the_inverse_of_a_time_is_a_rate_in_sysml(tmp_path):
    figure = of_sysml(tmp_path, "rate = 1 / life;")
    assert (figure.value, figure.per) == (pytest.approx(2e-5), Basis.HOUR)
    assert of_sysml(tmp_path, "mtbf = 1 / (500 [FIT]);").value == pytest.approx(5e-7)


def test_what_was_given_is_shown_beside_the_rate(tmp_path):
    figure = of_yaml(tmp_path, "mttfd: {value: 150, unit: year, dangerous: 0.5, error_factor: 3}")
    assert figure_text(figure) == (
        "1.52207e-06 per hour (rate), of MTTFd 1314000 h = 150 years, 50 % of the failures "
        "dangerous, error factor 3 (p95 / p50); the value is the mean"
    )


@pytest.mark.parametrize(
    ("at", "words"),
    [
        ("", "4.5e-07 per hour (rate), of 450 FIT"),
        (", temperature: {rated: 40, working: 40, activation_energy: 0.5}", "450 FIT at 40 degC"),
    ],
)
def test_a_figure_in_fit_is_shown_as_the_data_sheet_states_it(tmp_path, at, words):
    figure = of_yaml(tmp_path, f"failure_rate: {{value: 450, unit: FIT{at}}}")
    assert words in figure_text(figure)
    assert figure == of_yaml(tmp_path, "failure_rate: {value: 4.5e-7, per: hour}") or at
    if not at:
        assert figure_text(of_sysml(tmp_path, "rate = 450 [FIT];")) == figure_text(figure)


TWO = "components:\n  a: {twin: {gripper: true}, mtbf: {value: 1e5, unit: hour}}  # mine\n"


@pytest.mark.parametrize(
    ("row", "line"),
    [
        ("a,mttf,,20,year,", "mttf: {value: 20, unit: year, source: rates.csv}"),
        ("a,b10d,,3e6,,2", "b10d: {value: 3000000, error_factor: 2, source: rates.csv}"),
    ],
)
def test_a_table_gives_what_data_sheets_state(tmp_path, row, line):
    (tmp_path / "h.yaml").write_text(TWO)
    name, kind, _, value, per, factor = row.split(",")
    table = tmp_path / "rates.csv"
    table.write_text(f"component,{kind},per,error_factor\n{name},{value},{per},{factor}\n")
    figures = read_figures(table, read_description(tmp_path / "h.yaml"))
    text = with_figures(tmp_path / "h.yaml", figures)
    assert line in text
    assert "mtbf" not in text
    assert "# mine" in text


@pytest.mark.parametrize(
    ("figure", "column", "key"),
    [
        ("b10d: {value: 2e7, dangerous: 0.5}", "b10d", "dangerous"),
        ("b10: {value: 2e7, cycles: {value: 120, per: hour}}", "b10", "cycles"),
        (
            "failure_rate: {value: 1e-6, per: hour,"
            " temperature: {rated: 40, working: 55, activation_energy: 0.7}}",
            "failure_rate",
            "temperature",
        ),
        ("probability: {value: 1e-6, per: demand, of: grasp}", "failure_rate", "of"),
    ],
)
def test_a_table_does_not_drop_what_it_cannot_say(tmp_path, figure, column, key):
    path = tmp_path / "h.yaml"
    path.write_text(f"components:\n  a: {{twin: {{gripper: true}}, {figure}}}\n")
    table = tmp_path / "rates.csv"
    table.write_text(f"component,{column}\na,1000\n")
    figures = read_figures(table, read_description(path))
    with pytest.raises(InputError, match=f"has '{key}', for which a table has no column"):
        with_figures(path, figures)


def test_failures_in_the_field_replace_a_mean_time_by_its_rate(tmp_path):
    for figure in (
        "mtbf: {value: 1e5, unit: hour}",
        "failure_rate: {value: 10000, unit: FIT}",
    ):
        path = tmp_path / "h.yaml"
        path.write_text(f"components:\n  a:\n    twin: {{gripper: true}}\n    {figure}\n")
        (tmp_path / "f.csv").write_text("component,failures,hours\na,4,1000000\n")
        observed = read_failures(tmp_path / "f.csv")
        changes = updates(read_description(path), observed, str(tmp_path / "f.csv"))
        path.write_text(updated_yaml(path, changes))
        (component,) = read_description(path).components
        assert component.figures == (changes[0].after,)
        assert component.figures[0].value == pytest.approx(4.5e-6, rel=1e-3)


def test_a_temperature_in_kelvin_is_a_warning_in_either_format(tmp_path):
    at = "rated: 40, working: 328.15, activation_energy: 0.7"
    yaml = tmp_path / "h.yaml"
    yaml.write_text(
        "components:\n  a:\n    twin: {gripper: true}\n"
        f"    mtbf: {{value: 1e6, unit: hour, temperature: {{{at}}}}}\n"
    )
    (warning,) = read_description(yaml).warnings
    assert warning.startswith(f"{yaml}:2:")
    assert "a: the temperature multiplies the rate by" in warning
    assert "between 0.01 and 100: are 40 and 328.15 in degC" in warning
    sysml = tmp_path / "h.sysml"
    sysml.write_text(write_description(read_description(yaml), "sysml"))
    (again,) = read_description(sysml).warnings
    assert again.partition("a: ")[2] == warning.partition("a: ")[2]
    both = yaml.read_text().replace("rated: 40", "rated: 313.15")
    yaml.write_text(both)
    (warning,) = read_description(yaml).warnings
    assert "a: a temperature of 328.15 degC is above 200: is it in kelvin?" in warning
    usual = both.replace("313.15", "40").replace("328.15", "55")
    yaml.write_text(usual)
    assert read_description(yaml).warnings == ()
