"""A simulated robot joint: plant, drive and measurement chain of its own, nothing of the estimator's simulation.

Recordings of it are made in `run`, which the node that plays it does without.
"""

from flex_ident.virtual_joint.drive import INTERFACES, Drive, Interface, ample_effort, drive_for
from flex_ident.virtual_joint.experiment import Experiment
from flex_ident.virtual_joint.joint import Instruments, Measurement, VirtualJoint
from flex_ident.virtual_joint.joints import COBOT_JOINT, JOINTS, PAPER_JOINT, SERIES_ELASTIC_JOINT
from flex_ident.virtual_joint.measurement import PERFECT, MeasurementChain, chain_for
from flex_ident.virtual_joint.motion import TrueMotion

__all__ = [
    "COBOT_JOINT", "INTERFACES", "JOINTS", "PAPER_JOINT", "PERFECT", "SERIES_ELASTIC_JOINT", "Drive", "Experiment",
    "Instruments", "Interface", "Measurement", "MeasurementChain", "TrueMotion", "VirtualJoint", "ample_effort",
    "chain_for", "drive_for",
]  # fmt: skip
