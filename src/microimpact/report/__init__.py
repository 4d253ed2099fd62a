"""What is done with finished results: checked against references, compared with each other."""
