"""The graph in one process: topics, services, actions, parameters, the runtime."""
