"""A virtual joint, the exciter and the identifier: everything but a robot.

ros2 launch flex_ident simulated.launch.py
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node


def _nodes(context):
    joint, recordings = (context.launch_configurations[key] for key in ("joint", "recordings"))
    auto_start = context.launch_configurations["auto_start"] == "true"
    config = Path(get_package_share_directory("flex_ident")) / "config"
    more = {
        "simulated_joint": {},
        "chirp_exciter": {"auto_start": auto_start, "exit_when_done": False, "recording.directory": recordings},
        "identifier": {"bag_directories": [recordings]},
    }
    return [
        Node(
            package="flex_ident", executable=name, output="screen",
            parameters=[str(config / f"{name}.yaml"), {"joint": joint, **parameters}],
        )
        for name, parameters in more.items()
    ]  # fmt: skip


def generate_launch_description():
    """The arguments, and three nodes; `auto_start:=false` waits for a call of /chirp_exciter/start."""
    return LaunchDescription([
        DeclareLaunchArgument("joint", default_value="joint_1", description="name of the virtual joint"),
        DeclareLaunchArgument(
            "auto_start", default_value="true", choices=["true", "false"], description="start as soon as all is ready"
        ),
        DeclareLaunchArgument(
            "recordings", default_value="flex_ident_recordings", description="where bags are written and read"
        ),
        OpaqueFunction(function=_nodes),
    ])  # fmt: skip
