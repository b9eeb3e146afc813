"""What an assessor keeps of a figure: what it was made from, and how to make it again."""
