"""Stand-in for kdl_parser_py: trees of PyKDL from descriptions of robots."""
