"""The parts of a trace: what elements of the robot did, and what a user should know."""
