"""An encoder's error that nobody sees is said of the first moments that it would move: a plant of `bench`."""

import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flex_ident.effects import CATALOGUE
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.estimation.unseen_effects import encoder_notice, unseen_covariance
from flex_ident.parameters.values import Values
from flex_ident.report.sentences import sentence

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from plants import case_of, made
from recordings import recording_of

CODE = "encoder_taken_as_true"


def said(moved: float, std: float) -> Any:
    fit: Any = SimpleNamespace(values=Values({"MX": 0.6, "MY": 6.0}))
    known: Any = SimpleNamespace(std=lambda key: {"MX": 0.04, "MY": std}[key])
    return encoder_notice({"MX": 0.01, "MY": moved}, fit, known)


def test_it_is_said_of_the_moment_that_moves_most() -> None:
    notice = said(0.5, 0.51)
    assert (notice.code, notice.subject) == (CODE, "MY")
    assert "would move it by 0.5, and over this range nothing tells" in sentence(notice)


@pytest.mark.parametrize(("moved", "std"), [(0.5, 1.0), (0.02, 0.02), (0.0, 0.02)])
def test_what_the_interval_holds_or_is_little_of_all_gravity_is_not_spoken_of(moved: float, std: float) -> None:
    assert said(moved, std) is None


def test_an_error_in_the_model_is_not_beside_itself() -> None:
    unseen = CATALOGUE["link_encoder_error"].unseen
    assert unseen is not None
    assert len(unseen(Values({"K": 1e4}))) == 4
    assert not unseen(Values({"K": 1e4}) | Values.of_effect("link_encoder_error", {"amplitude": 1e-4}))


@pytest.mark.parametrize(("rigid", "link"), [(False, None), (True, np.zeros(3))])
def test_without_a_link_encoder_or_a_spring_there_is_none(rigid: bool, link: Any) -> None:
    solver: Any = SimpleNamespace(problem=SimpleNamespace(rigid=rigid, link=link))
    fit: Any = SimpleNamespace(values=Values({"K": 1e4}))
    assert unseen_covariance(solver, fit, "measurement") is None
    assert encoder_notice({}, fit, SimpleNamespace(std=lambda _key: 1.0)) is None  # type: ignore[arg-type]


@pytest.mark.campaign
def test_first_moments_behind_an_eccentric_encoder_are_open_by_what_that_does() -> None:
    """MX and MY of an adversary's arms were 5 to 23 standard deviations off, trusted; MX of this one is 19."""
    plant = made(case_of(701, 11))
    recording = recording_of(plant.recorded, "motor+link")
    assert recording.link_position is not None
    bent = recording.link_position + 1e-4 * np.sin(recording.link_position + 0.5)
    result = identify(replace(recording, link_position=bent), IdentifyOptions())
    assert result.verdict == "trusted"
    for p in result.parameters:
        if p.key in plant.truth:
            assert abs(p.value - plant.truth[p.key]) < 3.0 * p.std, p
    assert next(n for n in result.notices if n.code == CODE).subject == "MX"
