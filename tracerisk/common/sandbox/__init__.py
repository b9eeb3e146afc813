"""Processes that run what strangers wrote: what they may reach, and how they end."""
