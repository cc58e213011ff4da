"""Reading rosbag2 and ROS 1 recordings into signals."""

from flex_ident.bags.motions import JointMotion, joint_motions
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection

__all__ = ["JointMotion", "SignalSelection", "joint_motions", "read_recording"]
