"""The sections of the page that show the model: chain, trees, functions, components."""
