"""Definitions of messages, services and actions that a source uses and that are not here."""
