"""Exciter and identifier beside a robot that runs already.

ros2 launch flex_ident robot.launch.py joint:=elbow_joint config:=/path/to/ur.yaml
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    """Two nodes; nothing moves before a call of /chirp_exciter/start."""
    config = PathJoinSubstitution([FindPackageShare("flex_ident"), "config"])
    return LaunchDescription([
        DeclareLaunchArgument("joint", description="the joint that shall move"),
        DeclareLaunchArgument(
            "config", default_value=PathJoinSubstitution([config, "ros2_control.yaml"]),
            description="parameters of the exciter: one of config/*.yaml, or your own",
        ),
        Node(
            package="flex_ident", executable="chirp_exciter", output="screen",
            parameters=[LaunchConfiguration("config"), {"joint": LaunchConfiguration("joint"), "auto_start": False}],
        ),
        Node(
            package="flex_ident", executable="identifier", output="screen",
            parameters=[PathJoinSubstitution([config, "identifier.yaml"]), {"joint": LaunchConfiguration("joint")}],
        ),
    ])  # fmt: skip
