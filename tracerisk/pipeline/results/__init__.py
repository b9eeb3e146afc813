"""What is shown of results: alerts, derivations, pictures, spreads."""
