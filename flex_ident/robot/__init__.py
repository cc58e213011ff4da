"""What a robot's description says of one joint: the weight behind it, and which way that pulls."""

from flex_ident.robot.weight import weight_on

__all__ = ["weight_on"]
