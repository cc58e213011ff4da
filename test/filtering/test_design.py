"""The filter numbers of section 4 of the paper."""

import pytest

from flex_ident.commands.design_filter import design_filter
from flex_ident.errors import UsageError
from flex_ident.filtering.design import butterworth_cutoff_rad_s, filter_design, sampling_rate_hz

BANDWIDTH = 6 * 2 * 3.141592653589793 * 3.9


@pytest.mark.parametrize(("nd", "order", "cutoff", "rate"), [(2, 4, 181.04, 205.7), (4, 6, 168.91, 289.6)])
def test_section_4(nd: int, order: int, cutoff: float, rate: float) -> None:
    assert butterworth_cutoff_rad_s(BANDWIDTH / 1.0, order) == pytest.approx(cutoff, abs=0.3)
    assert sampling_rate_hz(BANDWIDTH, nd) == pytest.approx(rate, abs=0.3)


def test_decimation_of_section_4() -> None:
    design = filter_design(3.9, derivative_order=2, sample_rate_hz=350.87)
    assert design.decimation == 26
    assert design.decimation_cutoff_hz == pytest.approx(5.4, abs=0.01)


def test_figure_1_is_drawn(tmp_path) -> None:
    assert "eq. 28" in design_filter(3.9, figure=tmp_path / "figure_1.png")
    assert (tmp_path / "figure_1.png").stat().st_size > 5000


@pytest.mark.parametrize("mode", [0.0, float("nan"), float("inf")])
def test_refuses_a_mode_that_is_none(mode: float) -> None:
    with pytest.raises(UsageError, match="first mode"):
        filter_design(mode, derivative_order=2)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"sample_rate_hz": float("inf")}, "sampling rate is inf"),
        ({"decimation": 0}, "decimation is 0"),
        ({"order": 0}, "bandwidth 147 rad/s and order 0"),
    ],
)
def test_refuses_numbers_out_of_range(wrong: dict[str, float], text: str) -> None:
    with pytest.raises(UsageError, match=text):
        filter_design(3.9, derivative_order=2, **wrong)  # type: ignore[arg-type]


def test_a_rate_below_eq_29_is_a_warning() -> None:
    assert "warning" not in design_filter(3.9)
    assert "warning: 100 Hz is below the 205.7 Hz of eq. 29" in design_filter(3.9, sample_rate_hz=100.0)


def test_figure_that_cannot_be_written_is_named(tmp_path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="--figure"):
        design_filter(3.9, figure=tmp_path / "file" / "figure.png")
