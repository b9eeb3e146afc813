"""The settings as files give them: of a project, and of one controller."""
