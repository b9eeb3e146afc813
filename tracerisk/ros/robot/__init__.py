"""The robot's drivers on the graph: joint states, trajectories, set-points, grippers."""
