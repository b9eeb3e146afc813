"""Virtual time: one thread of the controller at a time, and clocks that obey it."""
