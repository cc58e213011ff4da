"""The chirp, and the rules under which a robot may follow it; knows nothing of ROS."""

from flex_ident.excitation.chirp import ChirpSettings, Reference, chirp_reference
from flex_ident.excitation.commands import Gains
from flex_ident.excitation.exciter import Exciter
from flex_ident.excitation.joint_states import JointSample
from flex_ident.excitation.limits import Limits
from flex_ident.excitation.output import Output
from flex_ident.excitation.settings import ExciterSettings

__all__ = [
    "ChirpSettings", "Exciter", "ExciterSettings", "Gains", "JointSample", "Limits", "Output", "Reference",
    "chirp_reference",
]  # fmt: skip
