"""The sections of the page that show the run: timeline, replay, contacts."""
