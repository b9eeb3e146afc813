"""The digital twin: the arm in its scene on MuJoCo."""
