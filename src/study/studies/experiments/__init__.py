"""Studies of Section 2: set-ups, instruments, measured means, and what is supposed behind them."""
