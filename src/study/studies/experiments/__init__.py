"""Studies of Section 2: set-ups, instruments, measured means, and their supposed causes."""
