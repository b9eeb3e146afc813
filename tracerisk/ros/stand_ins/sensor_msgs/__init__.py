"""Stand-in for the code of sensor_msgs; its messages are made from their texts."""
