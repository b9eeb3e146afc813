"""What a controller is given by the launch file that starts it."""

from tracerisk.pipeline.launch_files.records import LaunchParameter, LaunchSetup

__all__ = ["LaunchParameter", "LaunchSetup"]
