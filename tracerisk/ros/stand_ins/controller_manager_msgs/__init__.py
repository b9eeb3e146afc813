"""Stand-in for the code of controller_manager_msgs; its messages are made from their texts."""
