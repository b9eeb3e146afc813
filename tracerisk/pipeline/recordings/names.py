"""What a recording that tracerisk writes begins with and holds, and the rates of its states."""

JOINT_STATES = "/joint_states"
COMMANDS = "/tracerisk/commands"
VISITS = "/tracerisk/visits"
CONTACTS = "/tracerisk/contacts"
FINDINGS = "/tracerisk/findings"
TRACE = "tracerisk-trace.json"
"""The attachment that holds the trace."""
RATE_HZ = (50.0, 500.0)
"""The least and the greatest rate of joint states [Hz]."""
MAGIC = b"\x89MCAP0\r\n"
"""With which an MCAP file begins and ends (https://mcap.dev/spec)."""
