"""What the elements share; it imports none of them."""
