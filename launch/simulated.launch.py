"""A virtual joint, the exciter and the identifier: everything but a robot.

ros2 launch flex_ident simulated.launch.py
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    """Three nodes; `auto_start:=false` waits for a call of /chirp_exciter/start."""
    config = PathJoinSubstitution([FindPackageShare("flex_ident"), "config"])
    joint, recordings = LaunchConfiguration("joint"), LaunchConfiguration("recordings")
    auto_start = ParameterValue(LaunchConfiguration("auto_start"), value_type=bool)
    return LaunchDescription([
        DeclareLaunchArgument("joint", default_value="joint_1", description="name of the virtual joint"),
        DeclareLaunchArgument("auto_start", default_value="true", description="start as soon as all is ready"),
        DeclareLaunchArgument(
            "recordings", default_value="flex_ident_recordings", description="where bags are written and read"
        ),
        Node(
            package="flex_ident", executable="simulated_joint", output="screen",
            parameters=[PathJoinSubstitution([config, "simulated_joint.yaml"]), {"joint": joint}],
        ),
        Node(
            package="flex_ident", executable="chirp_exciter", output="screen",
            parameters=[PathJoinSubstitution([config, "chirp_exciter.yaml"]),
                        {"joint": joint, "auto_start": auto_start, "exit_when_done": False,
                         "recording.directory": recordings}],
        ),
        Node(
            package="flex_ident", executable="identifier", output="screen",
            parameters=[PathJoinSubstitution([config, "identifier.yaml"]),
                        {"joint": joint, "bag_directories": [recordings]}],
        ),
    ])  # fmt: skip
