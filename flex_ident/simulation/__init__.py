"""Stage 5: the joint simulated from its recorded motor position."""

from flex_ident.simulation.motion import MotorMotion, motor_motion
from flex_ident.simulation.response import LinkMotion, Response, simulated_response
from flex_ident.simulation.terms import BASE_TERMS, MEASUREMENT_TERMS, RIGID_TERMS, Term, no_terms

__all__ = [
    "BASE_TERMS", "MEASUREMENT_TERMS", "RIGID_TERMS", "LinkMotion", "MotorMotion", "Response",
    "Term", "motor_motion", "no_terms", "simulated_response",
]  # fmt: skip
