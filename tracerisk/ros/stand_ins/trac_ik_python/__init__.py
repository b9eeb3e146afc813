"""Stand-in for trac_ik_python: inverse kinematics of a chain of a URDF."""
