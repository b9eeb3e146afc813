"""Pictures of a run: a still of the arm for each function, what was active then in colour.

`moments` chooses the time, `placement` says where everything was, `pictures` puts a picture
together as plain data, and `drawn` has a process of its own draw it.
"""
