"""What several verbs share: options, output, the sources that they read."""
