"""The SysML v2 textual notation: tokens, syntax tree, names."""
