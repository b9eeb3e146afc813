"""Robot and scene as a MuJoCo model: bodies, contacts, collision."""
