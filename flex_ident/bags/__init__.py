"""Reading rosbag2 and ROS 1 recordings into signals."""
