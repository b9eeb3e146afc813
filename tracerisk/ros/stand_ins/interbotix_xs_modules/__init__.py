"""Stand-in for interbotix_xs_modules: X-series arms; the modules of ROS 1 and of ROS 2.

Those of ROS 1 stand here, those of ROS 2 in `xs_robot`. Both speak to the driver over the graph.
"""
