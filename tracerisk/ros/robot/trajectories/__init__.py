"""Trajectories as controllers of joint trajectories take them, by distribution and parameters."""
