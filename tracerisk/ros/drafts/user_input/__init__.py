"""What a user does with a game pad or with markers on a screen."""
