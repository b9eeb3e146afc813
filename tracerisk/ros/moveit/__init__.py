"""MoveIt's move_group on the twin: goals, planning scene, execution."""
