"""An effect is one file and one line of the catalogue: nothing else knows it by name, and nothing else needs to."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import flex_ident
from flex_ident.effects import CATALOGUE, Effect, EffectParameter, key_named, trade_error
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.effects.starting import Scans, Start
from flex_ident.estimation.estimate import fit_problem
from flex_ident.likelihood.fit import key_bounds
from flex_ident.likelihood.nuisances import model_priors
from flex_ident.parameters.prior import Prior
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import candidates
from flex_ident.simulation.terms import MEASUREMENT_KEYS, Term
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

ROOT = Path(flex_ident.__file__).parent
ALLOWED = {
    "virtual_joint/physics.py": "a plant that shares nothing with the catalogue reads the keys of model.yaml by itself",
}


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """Line and text of every string in a file that is no docstring, parts of f-strings too."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    spoken = {
        id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in spoken:
            yield node.lineno, node.value


def names_in(path: Path) -> list[str]:
    """Places in a file where a string is an effect's name, or a key of it; not where a nuisance is called the same."""
    own = set(CATALOGUE) - MEASUREMENT_KEYS
    return [
        f"{path.relative_to(ROOT)}:{line}: {text!r}"
        for line, text in texts(path)
        if text in own or any(text.startswith(f"{name}.") for name in CATALOGUE)
    ]


def test_no_module_outside_the_catalogue_names_an_effect() -> None:
    found = {str(path.relative_to(ROOT)): names_in(path) for path in sorted(ROOT.rglob("*.py"))}
    named = {path for path, places in found.items() if places and not path.startswith("effects/")}
    assert named == set(ALLOWED), [place for path in named - set(ALLOWED) for place in found[path]]


def test_an_effect_names_no_other_but_those_it_is_confused_with() -> None:
    for name, effect in CATALOGUE.items():
        found = {text.split(".")[0] for path in (ROOT / "effects").glob("*.py") if path.stem == name
                 for _, text in texts(path) if text.split(".")[0] in CATALOGUE}  # fmt: skip
        assert found - {name} == set(effect.confused_with), name


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda e: e.name)
def test_what_an_effect_says_of_itself_holds_together(effect: Effect) -> None:
    known = {p.name for p in effect.parameters}
    assert len({p.term for p in effect.parameters}) == len(known)
    assert set(effect.confused_with) <= set(CATALOGUE)
    assert {effect.refined[0], effect.cycles} - {""} <= known
    assert {p.term.side for p in effect.parameters} - {"motor", "link"} <= {effect.where, "both"}
    assert bool(effect.trades_with) == (effect.trade_error > 0.0)
    terms = {p.term for p in effect.parameters}
    assert all(t.shape_of is None or t.shape_of in terms for t in terms)


MADE_UP = Effect(
    name="made_up",
    summary="drag of the link that nobody has thought of",
    equation="drag v",
    parameters=(EffectParameter("drag", "N m s/rad", "of the link", Term.LINK_VISCOUS, lower=-1.0, upper=5.0),),
    probes=lambda scales: _probes(scales),
    start=lambda scans: _start(scans),
    priors=lambda recorded: {"drag": Prior(0.0, float(recorded.max()), -2.0, 4.0)},
    replaces="link_skew",
    trades_with=("FSm",),
    trade_error=0.1,
    where="link",
    signature="more friction",
    bin_by="link_velocity",
)


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("drag", scales.torque / scales.speed)


def _start(scans: Scans) -> Start:
    return Start(Values({"K": 2.0 * scans.values["K"]}), {"drag": 0.1 * scans.torque})


def test_an_effect_that_is_added_is_tried_started_and_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(CATALOGUE, "made_up", MADE_UP)
    chain = MeasurementChain(torque_noise=0.01)
    recording = virtual_recording(COBOT_JOINT, Experiment(duration_s=8.0, sample_rate_hz=500.0), chain)
    problem = fit_problem(recording, sensors="motor+link")
    values = Values({**COBOT_JOINT.parameters, "link_skew": 1e-4})
    (tried,) = (c for c in candidates(problem, values) if c.effect == "made_up")
    assert tried.keys == ("made_up.drag",)
    assert tried.replaces == "link_skew"
    assert tried.anew()["K"] == 2.0 * values["K"]
    assert tried.anew()["made_up.drag"] > 0.0
    assert tried.anew()["link_skew"] == 0.0
    priors = model_priors(problem, ["made_up"])
    assert "link_skew" not in priors
    assert key_bounds("made_up.drag", priors) == (-2.0, 4.0)
    assert key_bounds("made_up.drag", {}) == (-1.0, 5.0)
    key = key_named("made_up.drag")
    assert str(key) == "made_up.drag"
    assert (key.unit, key.is_force, key.side, key.logarithmic) == ("N m s/rad", True, "link", False)
    with_drag = values | {"made_up.drag": 3.0}
    assert trade_error("FSm", with_drag) == pytest.approx(0.3)
    assert trade_error("FV", with_drag) == 0.0
    drag = problem.residuals(values | {"FV": values["FV"] + 3.0})[0]
    assert (problem.residuals(with_drag)[0] == drag).all()


def test_a_start_that_finds_nothing_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(CATALOGUE, "made_up", replace(MADE_UP, start=lambda _: None))
    recording = virtual_recording(COBOT_JOINT, Experiment(duration_s=8.0, sample_rate_hz=500.0))
    problem = fit_problem(recording, sensors="motor")
    (tried,) = (c for c in candidates(problem, Values(COBOT_JOINT.parameters), effects=("made_up",)))
    assert tried.anew() == {}
