"""Arms of Universal Robots: their driver is described, the programs that they take are read."""
