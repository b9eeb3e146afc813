"""Stand-in for interbotix_perception_modules: tags and clusters of points that a camera sees.

The twin has no camera. What asks it raises `NoCameraError`, unless a service answers in its place;
only the arm's own base stays where it is, which the run reports.
"""
