"""Stand-in for interbotix_perception_modules: tags and clusters of points that a camera sees.

The twin has no camera: nothing is seen, unless a service answers in its place, and the arm's own
base stays where it is. The run reports each.
"""
