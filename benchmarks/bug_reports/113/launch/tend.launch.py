from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription([
        Node(
            package="tend_cell",
            executable="controller.py",
            name="tend",
            output="screen",
            parameters=[{"seconds_per_move": 2.5, "rounds": 2}],
        ),
    ])
