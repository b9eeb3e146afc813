"""What a user operates a program by, where nobody does: windows, and pages of a web server."""
