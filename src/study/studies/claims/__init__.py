"""Numbers that decide the claims of the article."""

# Columns of the table of numbers. A row with a problem stands for numbers that could not be
# computed; the case is empty where nothing is left open.
NUMBER_COLUMNS = ("claim", "case", "quantity", "value", "error", "code", "inputs", "problem")
