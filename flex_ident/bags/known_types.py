"""Message types of robots' drivers that a bag may hold without their definition: which fields, in which order.

A ROS 2 bag has definitions since Iron with MCAP, and since Jazzy with sqlite3. Of several versions the one is taken
that uses a message up to its end.
"""

from __future__ import annotations

PART = "\n" + "=" * 80 + "\nMSG: "


def _fields(*rows: str) -> str:
    """A definition from rows of a type and the names of fields that have it."""
    parts = (row.split() for row in rows)
    return "\n".join(f"{kind} {name}" for kind, *names in parts for name in names)


def _whole(main: str, **others: str) -> str:
    return main + "".join(f"{PART}{name.replace('__', '/')}\n{text}" for name, text in others.items())


def _franka(errors: int, *, robot: bool) -> str:
    """franka_msgs/FrankaRobotState, or the older FrankaState; `errors` are the flags of one Errors message."""
    last = (
        "float64 time control_command_success_rate",
        "uint8 robot_mode",
        "Errors current_errors last_motion_errors",
    )
    flags = {"franka_msgs__Errors": f"bool[{errors}] flags"}
    if not robot:
        state = _fields(
            "std_msgs/Header header", "float64[6] cartesian_collision cartesian_contact",
            "float64[7] q q_d dq dq_d ddq_d theta dtheta tau_j dtau_j tau_j_d", "float64[6] k_f_ext_hat_k",
            "float64[2] elbow elbow_d elbow_c delbow_c ddelbow_c", "float64[7] joint_collision joint_contact",
            "float64[6] o_f_ext_hat_k o_dp_ee_d o_dp_ee_c o_ddp_ee_c", "float64[7] tau_ext_hat_filtered",
            "float64 m_ee", "float64[3] f_x_cee", "float64[9] i_ee", "float64 m_load", "float64[3] f_x_cload",
            "float64[9] i_load", "float64 m_total", "float64[3] f_x_ctotal", "float64[9] i_total",
            "float64[16] o_t_ee o_t_ee_d o_t_ee_c f_t_ee ee_t_k", *last,
        )  # fmt: skip
        return _whole(state, **flags)
    state = _fields(
        "std_msgs/Header header", "CollisionIndicators collision_indicators",
        "sensor_msgs/JointState measured_joint_state desired_joint_state measured_joint_motor_state",
        "float64[7] ddq_d dtau_j", "sensor_msgs/JointState tau_ext_hat_filtered", "Elbow elbow",
        "geometry_msgs/WrenchStamped k_f_ext_hat_k o_f_ext_hat_k",
        "geometry_msgs/InertiaStamped inertia_ee inertia_load inertia_total",
        "geometry_msgs/PoseStamped o_t_ee o_t_ee_d o_t_ee_c f_t_ee ee_t_k",
        "geometry_msgs/TwistStamped o_dp_ee_d o_dp_ee_c", "geometry_msgs/AccelStamped o_ddp_ee_c", *last,
    )  # fmt: skip
    return _whole(
        state,
        franka_msgs__CollisionIndicators=_fields(
            "geometry_msgs/Vector3 is_cartesian_linear_collision is_cartesian_angular_collision "
            "is_cartesian_linear_contact is_cartesian_angular_contact",
            "float64[7] is_joint_collision is_joint_contact",
        ),
        franka_msgs__Elbow=_fields(
            "float64[2] position desired_position commanded_position commanded_velocity commanded_acceleration"
        ),
        **flags,
    )


def _trajectory_state(*points: str) -> str:
    multi = " ".join(f"multi_dof_{name}" for name in points)
    return _fields(
        "std_msgs/Header header", "string[] joint_names", f"trajectory_msgs/JointTrajectoryPoint {' '.join(points)}",
        "string[] multi_dof_joint_names", f"trajectory_msgs/MultiDOFJointTrajectoryPoint {multi}",
    )  # fmt: skip


ERRORS = (36, 39, 41)
"""Flags in franka_msgs/Errors, by version; those between differ by less than the bytes a message may have too many."""
KNOWN_TYPES: dict[str, tuple[str, ...]] = {
    "control_msgs/msg/DynamicJointState": (
        _whole(
            _fields("std_msgs/Header header", "string[] joint_names", "InterfaceValue[] interface_values"),
            control_msgs__InterfaceValue=_fields("string[] interface_names", "float64[] values"),
        ),
    ),
    "control_msgs/msg/JointControllerState": (
        _fields(
            "std_msgs/Header header",
            "float64 set_point process_value process_value_dot error time_step command p i d i_clamp",
            "bool antiwindup",
        ),
    ),
    "control_msgs/msg/JointTrajectoryControllerState": (
        _trajectory_state("reference", "feedback", "error", "output", "desired", "actual"),
        _trajectory_state("reference", "feedback", "error", "output"),
        _trajectory_state("desired", "actual", "error"),
    ),
    "franka_msgs/msg/FrankaRobotState": tuple(_franka(n, robot=True) for n in ERRORS),
    "franka_msgs/msg/FrankaState": tuple(_franka(n, robot=False) for n in ERRORS),
    "odrive_can/msg/ControllerStatus": (
        _fields(
            "float32 pos_estimate vel_estimate torque_target torque_estimate iq_setpoint iq_measured",
            "uint32 active_errors",
            "uint8 axis_state procedure_result",
            "bool trajectory_done_flag",
        ),
    ),
    "ur_msgs/msg/RobotStateRTMsg": (
        _fields(
            "float64 time",
            "float64[] q_target qd_target qdd_target i_target m_target q_actual qd_actual i_actual tool_acc_values "
            "tcp_force tool_vector tcp_speed",
            "float64 digital_input_bits",
            "float64[] motor_temperatures",
            "float64 controller_timer test_value robot_mode",
            "float64[] joint_modes",
        ),
    ),
}
"""Definitions as rosbag2 writes them, by message type."""
