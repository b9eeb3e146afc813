"""What follows a failure: how missions end, what nobody notices, and ways back."""
