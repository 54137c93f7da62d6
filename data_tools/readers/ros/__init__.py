"""Reader of ROS bags."""
