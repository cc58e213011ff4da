"""Exciter and identifier beside a robot that runs already; nothing moves before a call of /chirp_exciter/start.

ros2 launch flex_ident robot.launch.py joint:=elbow_joint config:=ur
ros2 service call /chirp_exciter/start std_srvs/srv/Trigger
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node


def _nodes(context):
    given = (context.launch_configurations[k] for k in ("joint", "config", "recordings", "namespace", "joint_states"))
    joint, config, recordings, namespace, joint_states = given
    shipped = Path(get_package_share_directory("flex_ident")) / "config"
    exciter = Path(config).expanduser() if config.endswith(".yaml") else shipped / f"{config}.yaml"
    if not exciter.is_file():
        known = ", ".join(sorted(p.stem for p in shipped.glob("*.yaml")))
        raise RuntimeError(f"config {config}: no such file; one of {known}, or the path of your own .yaml.")
    # A file for both nodes has a section of the identifier; one of the exciter alone is none of its business.
    own = [str(exciter)] if "/identifier:" in exciter.read_text(encoding="utf-8") else []
    return [
        Node(
            package="flex_ident", executable="chirp_exciter", namespace=namespace, output="screen",
            remappings=[("joint_states", joint_states)],
            parameters=[str(exciter), {"joint": joint, "auto_start": False, "exit_when_done": False,
                                       "recording.directory": recordings}],
        ),
        Node(
            package="flex_ident", executable="identifier", namespace=namespace, output="screen",
            parameters=[str(shipped / "identifier.yaml"), *own, {"joint": joint, "bag_directories": [recordings]}],
        ),
    ]  # fmt: skip


def generate_launch_description():
    """The arguments, and the two nodes."""
    return LaunchDescription([
        DeclareLaunchArgument("joint", description="the joint that shall move"),
        DeclareLaunchArgument(
            "config", default_value="ros2_control",
            description="the robot: franka, gen3, iiwa, ros2_control, so101, ur, xarm, or the path of your own .yaml",
        ),
        DeclareLaunchArgument(
            "recordings", default_value="flex_ident_recordings", description="where bags are written and read"
        ),
        DeclareLaunchArgument(
            "joint_states", default_value="joint_states", description="where the robot's joint states are published"
        ),
        DeclareLaunchArgument(
            "namespace", default_value="", description="the robot's namespace: all topics and nodes are taken below it"
        ),
        OpaqueFunction(function=_nodes),
    ])  # fmt: skip
