"""The functions of `tf.transformations`."""

from tf import transformations as _of_tf
from tf.transformations import *  # noqa: F403 - each name of it, as the real library has

__all__ = list(_of_tf.__all__)
