"""Parameters estimated from printed numbers (3.2.1), and how far the printed numbers fix them."""
