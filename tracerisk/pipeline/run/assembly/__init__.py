"""What a run is made of, each part built by one function: world, graph, watches, controller."""
