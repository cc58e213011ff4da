"""The chirp and the rules of moving a robot along it, without ROS."""
