"""Which controllers of the robot's driver run from the beginning, and which do later."""
