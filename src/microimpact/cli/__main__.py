"""``python -m microimpact.cli``."""

from microimpact.cli import main

main()
