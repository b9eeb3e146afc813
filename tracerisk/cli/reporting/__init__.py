"""What goes into a report, for the verbs that write or serve one."""
