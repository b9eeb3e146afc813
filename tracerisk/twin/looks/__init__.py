"""How robots look: geometry that is drawn and never simulated."""
