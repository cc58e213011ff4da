"""A process that listens to the exciter, as a commissioning tool does, and prints each state that comes to it."""

import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def main() -> None:
    """Listen until it is killed."""
    rclpy.init()
    node = rclpy.create_node("slow_listener")
    node.create_subscription(DiagnosticStatus, "/chirp_exciter/state", lambda m: print(m.message, flush=True), LATCHED)
    node.create_subscription(JointState, "/chirp_exciter/reference", lambda _: None, 1)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
