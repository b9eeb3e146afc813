"""What a controller reads of its cell, and whether it takes it for something else."""
