"""The hybrid model of a controller: built from blocks, solved, its importance."""
