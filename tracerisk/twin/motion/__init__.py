"""Kinematics, planning, timing and the carrying out of motions."""
