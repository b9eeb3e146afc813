"""What a program takes for an answer to `input()`, as its code compares it or takes it apart."""
