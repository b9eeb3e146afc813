"""The reader and the writer of hardware descriptions in SysML v2 textual notation."""
