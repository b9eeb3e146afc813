"""What a recording that tracerisk writes begins with and holds, and the rates of its states."""

JOINT_STATES = "/joint_states"
TF = "/tf"
TF_STATIC = "/tf_static"
DESCRIPTION = "/robot_description"
COMMANDS = "/tracerisk/commands"
VISITS = "/tracerisk/visits"
CONTACTS = "/tracerisk/contacts"
FINDINGS = "/tracerisk/findings"
TRACE = "tracerisk-trace.json"
"""The attachment that holds the trace."""
RATE_HZ = (50.0, 500.0)
"""The least and the greatest rate of joint states [Hz]."""
FRAMES_HZ = 100.0
"""The greatest rate of frames [Hz]: more than a screen shows."""
MAGIC = b"\x89MCAP0\r\n"
"""With which an MCAP file begins and ends (https://mcap.dev/spec)."""
