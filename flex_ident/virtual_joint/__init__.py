"""A simulated robot joint: plant, drive and measurement chain of its own, nothing of the estimator's simulation."""

from flex_ident.virtual_joint.drive import Drive, drive_for
from flex_ident.virtual_joint.experiment import Experiment
from flex_ident.virtual_joint.joint import Encoders, Measurement, VirtualJoint
from flex_ident.virtual_joint.joints import COBOT_JOINT, JOINTS, PAPER_JOINT, SERIES_ELASTIC_JOINT
from flex_ident.virtual_joint.measurement import PERFECT, MeasurementChain, TrueMotion
from flex_ident.virtual_joint.run import virtual_motion, virtual_recording

__all__ = [
    "COBOT_JOINT", "JOINTS", "PAPER_JOINT", "PERFECT", "SERIES_ELASTIC_JOINT", "Drive", "Encoders", "Experiment",
    "Measurement", "MeasurementChain", "TrueMotion", "VirtualJoint", "drive_for", "virtual_motion",
    "virtual_recording",
]  # fmt: skip
