"""Poses, and the tree of frames that tf2 keeps."""
