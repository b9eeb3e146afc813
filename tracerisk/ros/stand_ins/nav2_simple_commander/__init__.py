"""Stand-in for nav2_simple_commander: Nav2 asked to drive a mobile base, by its actions."""
