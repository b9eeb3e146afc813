"""The figures of a block: computed from a trace and a hardware description, and explained."""
