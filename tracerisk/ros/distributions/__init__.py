"""The distributions of ROS that are served: what differs between them, and what a run follows."""
