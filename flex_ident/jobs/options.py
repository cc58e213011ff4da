"""Settings, already checked one by one, as the options that the stages take."""

from __future__ import annotations

from collections.abc import Mapping

from flex_ident.configuration.settings import Value
from flex_ident.effects import check_effect_parameters
from flex_ident.errors import ConfigurationError, FlexIdentError
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap.options import GapOptions
from flex_ident.jobs.signals import names_in, text_setting
from flex_ident.parameters import JointModel, read_joint_model
from flex_ident.parameters.effort_kinds import CURRENT, MOTOR
from flex_ident.recording.names import at_home


def given_model(values: Mapping[str, Value]) -> JointModel | None:
    """The model file's content, if one was given. Raises ConfigurationError."""
    path = text_setting(values, "model")
    if not path:
        return None
    model = read_joint_model(at_home(path))
    try:
        for name, parameters in model.effects.items():
            check_effect_parameters(name, dict(parameters))
    except FlexIdentError as error:
        raise ConfigurationError(f"{path}: {error}") from error
    return model


def effort_kind(values: Mapping[str, Value]) -> str:
    """The kind of effort asked for; a current whose scale is given is the motor's torque."""
    kind = str(values["effort_kind"])
    return MOTOR if kind == CURRENT and float(values["effort_scale"]) != 1.0 else kind


def identify_options(values: Mapping[str, Value]) -> IdentifyOptions:
    """How to identify. Raises UsageError and ConfigurationError."""
    return IdentifyOptions(
        sensors=str(values["sensors"]),
        method=str(values["method"]),
        rigid=bool(values["rigid"]),
        first_mode_hz=float(values["first_mode_hz"]) or None,
        band_hz=float(values["band_hz"]) or None,
        model=given_model(values),
        cutoff_sweep=bool(values["cutoff_sweep"]),
        effort_kind=effort_kind(values),
    )


def gap_options(values: Mapping[str, Value]) -> GapOptions:
    """How to search. Raises UsageError and ConfigurationError."""
    return GapOptions(
        sensors=str(values["sensors"]),
        rigid=bool(values["rigid"]),
        without=names_in(values["without"]),
        effects=names_in(values["effects"]),
        add=names_in(values["add"]),
        model=given_model(values),
        first_mode_hz=float(values["first_mode_hz"]) or None,
        band_hz=float(values["band_hz"]) or None,
        prismatic=bool(values["prismatic"]),
        effort_kind=effort_kind(values),
    )
