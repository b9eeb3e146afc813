"""Loggers."""

from rclpy._logger import RcutilsLogger

__all__ = ["RcutilsLogger"]
