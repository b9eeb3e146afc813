"""The robot that a controller's own workspace describes."""
