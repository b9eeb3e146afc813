"""The actions of move_group beyond planning: whose turn it is, picking and placing."""
